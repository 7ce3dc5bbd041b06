# Warnings for every target of this project, never for those who link it.
function(cornerfix_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 sees an overlap in `"text" + std::to_string(n)` that is not there (its bug 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
  if(CORNERFIX_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()
