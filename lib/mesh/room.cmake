pbdsurg_room(mesh
  HEADERS mesh_data.h partition.h tet_mesh.h topology.h
  SOURCES partition.cpp tet_mesh.cpp topology.cpp)
if(PBDSURG_HAS_METIS)
  pbdsurg_link_private(pbdsurg_core METIS::METIS)
  set_source_files_properties("${PROJECT_SOURCE_DIR}/lib/mesh/partition.cpp"
    PROPERTIES COMPILE_DEFINITIONS PBDSURG_HAS_METIS)
endif()
