# cornerfix_test(NAME LABEL label SOURCES ... LIBRARIES ... [FILTER filter]): one GoogleTest program, its tests found
# and labelled; those that the filter takes, if there is one.
function(cornerfix_test name)
  cmake_parse_arguments(ARG "" "LABEL;FILTER" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} GTest::gmock_main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/tests)
  target_precompile_headers(${name} PRIVATE <gmock/gmock.h> <gtest/gtest.h> <cornerfix/cornerfix.hpp>)
  # A test is compiled more often than it runs; what it tests keeps its own optimisation.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  cornerfix_warnings(${name})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 reports strings of impossible lengths at this optimisation (its bugs 105329 and 105651).
    target_compile_options(${name} PRIVATE -Wno-array-bounds -Wno-stringop-overflow)
  endif()
  gtest_discover_tests(${name} TEST_FILTER "${ARG_FILTER}" PROPERTIES LABELS ${ARG_LABEL} DISCOVERY_TIMEOUT 60)
endfunction()
