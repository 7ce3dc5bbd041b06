if(CORNERFIX_SANITIZE)
  add_compile_options(-fsanitize=${CORNERFIX_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${CORNERFIX_SANITIZE})
endif()
