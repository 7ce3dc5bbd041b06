# Compiles a target as all tests are. A test is compiled more often than it runs; what it tests keeps
# its own optimisation.
function(cornerfix_compile_as_test target)
  target_link_libraries(${target} PRIVATE GTest::gmock_main)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/tests)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  cornerfix_warnings(${target})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 reports strings of impossible lengths at this optimisation (its bugs 105329 and 105651).
    target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-stringop-overflow)
  endif()
endfunction()

# The headers that every test includes, precompiled once for all of them.
add_library(cornerfix_test_headers OBJECT ${CMAKE_CURRENT_LIST_DIR}/test_headers.cpp)
target_link_libraries(cornerfix_test_headers PRIVATE cornerfix::core)
target_precompile_headers(cornerfix_test_headers PRIVATE <gmock/gmock.h> <gtest/gtest.h> <cornerfix/cornerfix.hpp>)
cornerfix_compile_as_test(cornerfix_test_headers)

# cornerfix_test(NAME LABEL label SOURCES ... LIBRARIES ... [EXCEPT pattern]): one GoogleTest program. Each of its suites
# is one labelled test of CTest, so that what a suite shares is made once; `pattern` leaves tests out.
function(cornerfix_test name)
  cmake_parse_arguments(ARG "" "LABEL;EXCEPT" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES})
  cornerfix_compile_as_test(${name})
  target_precompile_headers(${name} REUSE_FROM cornerfix_test_headers)
  set(suites ${CMAKE_CURRENT_BINARY_DIR}/${name}_suites.cmake)
  add_custom_command(TARGET ${name} POST_BUILD BYPRODUCTS ${suites} VERBATIM
    COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:${name}> -D "EXCEPT=${ARG_EXCEPT}" -D LABEL=${ARG_LABEL}
      -D OUTPUT=${suites} -P ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/list_suites.cmake)
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${name}_tests.cmake
    "if(EXISTS ${suites})\n  include(${suites})\nelse()\n  add_test(${name}_NOT_BUILT ${name}_NOT_BUILT)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}_tests.cmake)
endfunction()
