// The strip of the tutorial for Gmsh, lengths in mm:  gmsh -3 strip.geo -o strip.msh
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 40, 10, 4};
Mesh.CharacteristicLengthMax = 2;
