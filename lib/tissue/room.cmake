pbdsurg_room(tissue
  HEADERS look.h material.h thermal_properties.h library.h
          scene.h topology_edit.h tissue_change.h renumbering.h follower.h tissue.h
  SOURCES material.cpp thermal_properties.cpp library.cpp scene.cpp compact.cpp edit_checks.cpp
          follower.cpp hinges.cpp new_bodies.cpp part_tissue.cpp removal.cpp split_tets.cpp tissue.cpp
          tissue_data.cpp)
