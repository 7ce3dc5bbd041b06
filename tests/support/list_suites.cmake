# Writes the tests of CTest for one GoogleTest program: one per suite.
# -D PROGRAM=... -D EXCEPT=pattern of tests that are left out, may be empty -D LABEL=... -D OUTPUT=...
set(except "")
if(EXCEPT)
  set(except "-${EXCEPT}")
endif()
execute_process(COMMAND ${PROGRAM} --gtest_list_tests "--gtest_filter=*${except}"
  OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\n[A-Za-z0-9_/]+\\." suites "\n${listing}")
if(NOT suites)
  message(FATAL_ERROR "${PROGRAM} lists no test")
endif()
set(tests "")
foreach(suite IN LISTS suites)
  string(REGEX REPLACE "^\n|\\.$" "" suite "${suite}")
  string(APPEND tests "add_test([==[${suite}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${suite}.*${except}]==])\n"
    # Skipped where every test was skipped and none failed.
    "set_tests_properties([==[${suite}]==] PROPERTIES LABELS ${LABEL}"
    " FAIL_REGULAR_EXPRESSION [==[Running 0 tests]==]"
    " SKIP_REGULAR_EXPRESSION [==[PASSED  \\] 0 tests[.]\n(\\[  SKIPPED \\][^\n]*\n)+$]==])\n")
endforeach()
file(WRITE ${OUTPUT} "${tests}")
