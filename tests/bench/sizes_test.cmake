# SPDX-License-Identifier: Apache-2.0
# Runs sizes on the smallest mesh and reads what it leaves behind. It fails by itself if threads end
# otherwise than the serial executor, or stages do not make up the frame. How busy the machine is
# decides the times, so none is compared; edits of quiet frames take none.
include("${CMAKE_CURRENT_LIST_DIR}/table_test.cmake")

# expect_row(row executor): a row is that executor's, and its sizes and times are above zero.
function(expect_row row executor)
  string(JSON name GET "${json}" sizes ${row} executor)
  expect("executor of row ${row}" "${name}" "${executor}")
  expect_positive(sizes ${row} tets vertices tissue_mb solver_mb tissue_ms solver_ms heat_ms
    quiet_step_ms quiet_readback_ms quiet_frame_ms burn_heat_ms burn_edit_ms burn_step_ms
    burn_readback_ms burn_frame_ms removed_tets)
  if(NOT IS_SANITIZED)  # a sanitizer has an allocator of its own
    expect_positive(sizes ${row} heat_mb surface_mb heap_mb resident_mb heap_bytes_per_tet)
  endif()
endfunction()

run_table(sizes 0 --quick)
string(JSON count LENGTH "${json}" sizes)
if(out MATCHES "- no cuda: [a-zA-Z]")
  expect("rows" "${count}" 2)
else()
  expect("rows" "${count}" 3)
  expect_row(2 cuda)
endif()
expect_row(0 serial)
expect_row(1 threads)

run_table(sizes 0 --quick --executor threads:2)
string(JSON count LENGTH "${json}" sizes)
expect("rows of one executor" "${count}" 1)
expect_row(0 threads:2)

# what there is not is refused by name
run_table(sizes 2 --quick --executor fast)
if(NOT error MATCHES "there is no executor 'fast'")
  message(SEND_ERROR "an executor that there is not: ${error}")
endif()
