pbdsurg_room(solver
  HEADERS material.h scene.h solver.h step_plan.h step_report.h tool.h
  SOURCES contact_stage.cpp edge_owners.cpp material.cpp scene.cpp serial_backend.cpp serial_phases.cpp
          solver.cpp state_report.cpp)
