pbdsurg_room(mesh
  HEADERS check.h implicit_shape.h length_unit.h mesh_data.h partition.h quality.h read.h series.h
          surface_distance.h tet_mesh.h tetrahedralize.h topology.h write.h
  SOURCES tet_mesh.cpp topology.cpp partition.cpp
          # reading
          length_unit.cpp source.cpp cells.cpp point_ids.cpp xml_reader.cpp encoded_stream.cpp
          read.cpp read_msh.cpp read_vtk.cpp read_vtu.cpp read_tetgen.cpp read_medit.cpp
          read_stl.cpp read_obj.cpp read_ply.cpp
          # writing
          write.cpp write_msh.cpp write_vtk.cpp write_vtu.cpp write_surface.cpp
          series.cpp
          # judging
          quality.cpp check.cpp point_check.cpp surface_check.cpp surface_crossing.cpp
          # making
          implicit_shape.cpp surface_distance.cpp triangle_orientation.cpp lattice.cpp stuffing.cpp
          boundary_check.cpp smoothing.cpp tetrahedralize.cpp)
if(PBDSURG_HAS_METIS)
  pbdsurg_link_private(pbdsurg_core METIS::METIS)
  set_source_files_properties("${PROJECT_SOURCE_DIR}/lib/mesh/partition.cpp"
    PROPERTIES COMPILE_DEFINITIONS PBDSURG_HAS_METIS)
endif()
