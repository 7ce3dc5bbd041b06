# Warnings for every target of this project, never for those who link it.
function(cornerfix_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow)
  if(CORNERFIX_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()
