# Writes a file for ctest with a test for each suite of a GoogleTest program.
# usage: cmake -D PROGRAM=... -D WITHOUT=PATTERNS -D TIMEOUT=S -D LABEL=... -D OUTPUT=FILE -P list_suites.cmake
#   WITHOUT  the tests that are left out, as in --gtest_filter
execute_process(COMMAND ${PROGRAM} --gtest_list_tests "--gtest_filter=*-${WITHOUT}"
  OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "\n" ";" lines "${listed}")
set(text "")
foreach(line IN LISTS lines)
  # A suite begins in the first column and ends with a full stop; its tests are indented.
  if(line MATCHES "^([^ ]+)\\.( |$)")
    set(suite ${CMAKE_MATCH_1})
    string(APPEND text
      "add_test(\"${suite}\" \"${PROGRAM}\" \"--gtest_filter=${suite}.*-${WITHOUT}\")\n"
      "set_tests_properties(\"${suite}\" PROPERTIES TIMEOUT ${TIMEOUT} LABELS ${LABEL} "
      "SKIP_REGULAR_EXPRESSION \"PASSED  . 0 tests\")\n")
  endif()
endforeach()
if(text STREQUAL "")
  message(FATAL_ERROR "${PROGRAM} has no tests but ${WITHOUT}")
endif()
file(WRITE ${OUTPUT} "${text}")
