# SPDX-License-Identifier: Apache-2.0
# A second against the clock. Would catch a force that is not that of the static solution, a tool that
# loses its tissue or its heat, and a verdict where no GPU steps. Times are no gate.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(haptic_rate 0 --quick --executor threads)

string(JSON count LENGTH "${json}" haptic_rate)
expect("rows" "${count}" 1)
expect_positive(haptic_rate 0 steps step_ms p999_ms heat_ms solver_ms contact_ms late_ms force_n felt_n)
string(JSON touching GET "${json}" haptic_rate 0 touching_percent)
string(JSON burning GET "${json}" haptic_rate 0 burning_percent)
string(JSON error GET "${json}" haptic_rate 0 error_percent)
string(JSON type TYPE "${json}" haptic_rate 0 ok)
expect("type of ok without a GPU" "${type}" NULL)
if(touching LESS 90 OR burning LESS 80)
  message(SEND_ERROR "the tool touches in ${touching} % of the steps and burns in ${burning} % of heats")
endif()
if(error GREATER 1)
  message(SEND_ERROR "the force is ${error} % off")
endif()
