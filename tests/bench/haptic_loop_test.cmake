# SPDX-License-Identifier: Apache-2.0
# Runs three seconds of the loop. Would catch a force that is not that of the static solution, and
# tissue that does not follow the tool.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(haptic_loop 0 --quick --executor threads)

string(JSON count LENGTH "${json}" haptic_loop)
expect("rows" "${count}" 1)
expect_positive(haptic_loop 0 minutes step_ms p99_ms force_n static_n)
string(JSON non_finite GET "${json}" haptic_loop 0 non_finite)
expect("vertices that are not finite" "${non_finite}" 0)
string(JSON error GET "${json}" haptic_loop 0 error_percent)
string(JSON farthest GET "${json}" haptic_loop 0 farthest_mm)
if(error GREATER 1 OR farthest GREATER 0.1)
  message(SEND_ERROR "the force is ${error} % off, a vertex ${farthest} mm")
endif()
