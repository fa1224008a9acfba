pbdsurg_room(solver
  HEADERS compaction.h solver.h solver_options.h step_plan.h step_report.h tool.h
  SOURCES build_constraints.cpp choose_lane_kernels.cpp compaction.cpp constraint_numbers.cpp
          constraint_sets.cpp contact_stage.cpp edge_owners.cpp host_backends.cpp
          neo_hookean_record.cpp nested_domains.cpp serial_backend.cpp serial_phases.cpp solver.cpp
          solver_data.cpp solver_input.cpp solver_options.cpp solver_state.cpp state_follower.cpp
          state_report.cpp step_program.cpp step_scratch.cpp thread_choice.cpp threaded_backend.cpp vertex_blocks.cpp vertex_method.cpp)

# lane_kernels.cpp once for each instruction set and each way of rounding. Its objects hold no symbol
# in common, so that the linker cannot take code for one processor into the path of another.
pbdsurg_link_private(pbdsurg_core hwy::hwy)
function(pbdsurg_lane_kernels set name lanes)  # flags...
  foreach(rounding IN ITEMS strict fast)
    string(COMPARE EQUAL "${rounding}" "fast" is_fast)
    set(target pbdsurg_lanes_${set}_${rounding})
    add_library(${target} OBJECT "${PROJECT_SOURCE_DIR}/lib/solver/lane_kernels.cpp")
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON
      CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    target_compile_features(${target} PRIVATE cxx_std_20)
    target_include_directories(${target} PRIVATE
      "${PROJECT_SOURCE_DIR}/include" "${PROJECT_SOURCE_DIR}/lib"
      $<TARGET_PROPERTY:hwy::hwy,INTERFACE_INCLUDE_DIRECTORIES>)
    target_compile_definitions(${target} PRIVATE
      PBDSURG_LANES_NAMESPACE=lanes_${set}_${rounding} PBDSURG_LANES_FAST=${is_fast} PBDSURG_LANES_COUNT=${lanes}
      "PBDSURG_LANES_NAME=\"${name}, ${rounding}\"")
    target_compile_options(${target} PRIVATE
      $<TARGET_PROPERTY:pbdsurg_build_flags,INTERFACE_COMPILE_OPTIONS> ${ARGN}
      $<$<BOOL:${is_fast}>:-ffp-contract=fast>)
    target_sources(pbdsurg_core PRIVATE $<TARGET_OBJECTS:${target}>)
    set_property(GLOBAL APPEND PROPERTY PBDSURG_LANE_TARGETS ${target})
  endforeach()
endfunction()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  pbdsurg_lane_kernels(ssse3 "SSSE3" 4 -mssse3)
  pbdsurg_lane_kernels(avx2 "AVX2" 8 -march=haswell -maes)
  pbdsurg_lane_kernels(avx512 "AVX-512" 16 -march=skylake-avx512)
  set_source_files_properties(solver/choose_lane_kernels.cpp PROPERTIES
    COMPILE_DEFINITIONS PBDSURG_HAS_X86_LANES)
endif()
