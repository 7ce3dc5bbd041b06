if(CORNERFIX_SANITIZE)
  add_compile_options(-fsanitize=${CORNERFIX_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${CORNERFIX_SANITIZE})
endif()
if(CORNERFIX_BUILD_FUZZERS)
  # What is fuzzed tells the fuzzer which ways its code took; its own main comes with the targets.
  add_compile_options(-fsanitize=fuzzer-no-link)
  add_link_options(-fsanitize=fuzzer-no-link)
endif()
