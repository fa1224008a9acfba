pbdsurg_room(edit
  HEADERS change_log.h compaction.h cut.h followed_version.h live_boundary.h live_pieces.h
          live_surface.h topology_edit.h undo_array.h
  SOURCES change_log.cpp compaction.cpp cut.cpp cut_neighborhood.cpp cut_planner.cpp cut_surface.cpp
          edit_checks.cpp fingerprint.cpp followed_version.cpp live_boundary.cpp live_pieces.cpp
          live_surface.cpp part_tissue.cpp removal.cpp renumbering.cpp split_tets.cpp
          topology_edit.cpp)
