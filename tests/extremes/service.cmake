# The rows that need a server. The long form appends its records for the report.
if(STIEFEL_SERVICE)
  foreach(form short long)
    add_test(NAME extremes.service.${form}
             COMMAND ${STIEFEL_PYTHON} -m pytest -q -p no:cacheprovider ${CMAKE_CURRENT_LIST_DIR})
    set_tests_properties(extremes.service.${form} PROPERTIES TIMEOUT 1200 ENVIRONMENT
      "${STIEFEL_PYTHON_ENVIRONMENT};STIEFEL_EXTREMES=${form};STIEFEL_RECORDS=${PROJECT_BINARY_DIR}/extremes")
  endforeach()
  set_tests_properties(extremes.service.long PROPERTIES LABELS long RUN_SERIAL ON)
endif()
