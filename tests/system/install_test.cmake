# Installs the project and builds the example against what was installed, as a user would.
#   cmake -D BUILD_DIR=... -D SOURCE_DIR=... -D WORK_DIR=... -P install_test.cmake
file(REMOVE_RECURSE "${WORK_DIR}")
set(prefix "${WORK_DIR}/prefix")

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE_DIR}/docs/examples/localize_offline -B ${WORK_DIR}/example
  -D CMAKE_BUILD_TYPE=Release -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_FLAGS=${CXX_FLAGS})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/example)
run(${WORK_DIR}/example/localize_offline ${SOURCE_DIR}/tests/data/willow_full_0.05.yaml)

run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE_DIR}/tests/system/installed_package -B ${WORK_DIR}/package
  -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_FLAGS=${CXX_FLAGS} -D README=${SOURCE_DIR}/README.md)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/package)

run(${prefix}/bin/cornerfix --help)
if(NOT EXISTS ${prefix}/share/cornerfix/web/index.html)
  message(FATAL_ERROR "the inspector was not installed")
endif()
