# The layering test must find a wrong include.
#   cmake -D WORK_DIR=... -P layering_self_test.cmake
file(REMOVE_RECURSE "${WORK_DIR}")
foreach(line
    "core/src/a.cpp|#include \"server/routes.hpp\""
    "core/include/cornerfix/a.hpp|#include <opencv2/core.hpp>"
    "core/include/cornerfix/b.hpp|#include \"core/src/map/a.hpp\""
    "core/src/scan/a.cpp|#include \"core/src/map/a.hpp\""
    "core/src/search/a.hpp|#include <cornerfix/localizer.hpp>"
    "core/src/slam/a.cpp|#include \"a.hpp\""
    "server/b.cpp|#include \"core/src/map/a.hpp\""
    "tests/unit/core/map/a_test.cpp|#include \"evaluation/metrics/a.hpp\""
    "tests/system/a_test.cpp|#include \"cli/command.hpp\""
    "bench/a.cpp|#include \"cli/command.hpp\""
    "bench/rivals/a.cpp|#include \"evaluation/metrics/percentile.hpp\""
    "storage/a.cpp|#include <nlohmann/json.hpp>"
    "api/a.cpp|#include \"storage/database.hpp\""
    "evaluation/metrics/a.hpp|#include \"cli/command.hpp\""
    "evaluation/datasets/a.cpp|#include \"evaluation/metrics/percentile.hpp\""
    "evaluation/datasets/a.hpp|#include <nlohmann/json.hpp>"
    "clients/cpp/a.cpp|#include \"server/routes.hpp\""
    "server/a.hpp|#include <httplib.h>"
    "frames/a.hpp|#include \"evaluation/datasets/log_reader.hpp\""
    "ros2/a.cpp|#include \"server/http_server.hpp\""
    "cli/a.cpp|#include <dds/dds.h>"
    "server/a.cpp|#include <sqlite3.h>"
    "web/app.js|fetch('v1/maps')")
  string(REPLACE "|" ";" parts "${line}")
  list(GET parts 0 file)
  list(GET parts 1 text)
  set(tree "${WORK_DIR}/tree")
  file(REMOVE_RECURSE "${tree}")
  file(WRITE "${tree}/${file}" "${text}\n")
  execute_process(COMMAND ${CMAKE_COMMAND} -D SOURCE_DIR=${tree} -P ${CMAKE_CURRENT_LIST_DIR}/layering_test.cmake
    RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE message)
  if(result EQUAL 0 OR NOT message MATCHES "${file}")
    message(FATAL_ERROR "not found: ${file}: ${text}\n${message}")
  endif()
endforeach()
