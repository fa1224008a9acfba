# SPDX-License-Identifier: Apache-2.0
# Runs the cases of contact that take seconds. Would catch tissue that slides, sticks, weighs or gives way
# otherwise than closed forms say, or that a thin tool passes.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")
run_table(contact 0 --quick --executor serial)

string(JSON count LENGTH "${json}" contact)
expect("rows" "${count}" 70)
# Short of their aims, see docs/guide/tools.md, "At rest": plates, and a membrane without damping. They may get no worse.
set(short_of_aim "^(plate|ball) .*at rest")
set(worst_short_of_aim 60)  # %
foreach(row RANGE 69)
  string(JSON within GET "${json}" contact ${row} is_within)
  string(JSON case GET "${json}" contact ${row} case)
  string(JSON error GET "${json}" contact ${row} error_percent)
  if(NOT within STREQUAL "yes" AND NOT (case MATCHES "${short_of_aim}" AND error LESS worst_short_of_aim))
    string(JSON method GET "${json}" contact ${row} method)
    message(SEND_ERROR "${case}, ${method}: off by ${error} %")
  endif()
endforeach()

# By turns and stages, on one thread: the row without contact, then what others add.
string(JSON count LENGTH "${json}" contact_cost)
if(count LESS 8)
  message(SEND_ERROR "contact_cost has ${count} rows")
endif()
string(JSON contacts GET "${json}" contact_cost 3 contacts)
if(contacts LESS 100)
  message(SEND_ERROR "only ${contacts} contacts of bodies and tools are timed")
endif()
