// A flat dog-bone: tension specimen with wide grip tabs, like a ligament with its bone blocks. Lengths in mm, axis z.
//   gmsh -3 dogbone.geo -o dogbone.msh        (Gmsh 4.8.4; the options below fix format, order and random numbers)
// Tabs 14 wide (z 0..12 and 48..60), gauge 6 wide (z 20..40), 4 thick; centred on x = 0 and y = 0.
// Between tab and gauge an S of two arcs of radius 5 that meet with a common tangent: the 3-4-5 triangle.

SetFactory("Built-in");
Mesh.MshFileVersion = 4.1;
Mesh.Binary = 0;
Mesh.ElementOrder = 1;
Mesh.Algorithm = 6;
Mesh.Algorithm3D = 1;
Mesh.Optimize = 1;
Mesh.OptimizeThreshold = 0.5;
Mesh.RandomSeed = 1;
General.NumThreads = 1;

tab = 2.6;    // size of the cells [mm]
fillet = 1.7;
gauge = 1.4;

// The right side of the face y = -2, upwards.
Point(1) = {7, -2, 0, tab};
Point(2) = {7, -2, 12, tab};
Point(3) = {5, -2, 16, fillet};
Point(4) = {3, -2, 20, gauge};
Point(5) = {3, -2, 40, gauge};
Point(6) = {5, -2, 44, fillet};
Point(7) = {7, -2, 48, tab};
Point(8) = {7, -2, 60, tab};
// The left side, downwards.
Point(9) = {-7, -2, 60, tab};
Point(10) = {-7, -2, 48, tab};
Point(11) = {-5, -2, 44, fillet};
Point(12) = {-3, -2, 40, gauge};
Point(13) = {-3, -2, 20, gauge};
Point(14) = {-5, -2, 16, fillet};
Point(15) = {-7, -2, 12, tab};
Point(16) = {-7, -2, 0, tab};
// Centres of the arcs.
Point(17) = {2, -2, 12};
Point(18) = {8, -2, 20};
Point(19) = {8, -2, 40};
Point(20) = {2, -2, 48};
Point(21) = {-2, -2, 48};
Point(22) = {-8, -2, 40};
Point(23) = {-8, -2, 20};
Point(24) = {-2, -2, 12};

Line(1) = {1, 2};
Circle(2) = {2, 17, 3};
Circle(3) = {3, 18, 4};
Line(4) = {4, 5};
Circle(5) = {5, 19, 6};
Circle(6) = {6, 20, 7};
Line(7) = {7, 8};
Line(8) = {8, 9};
Line(9) = {9, 10};
Circle(10) = {10, 21, 11};
Circle(11) = {11, 22, 12};
Line(12) = {12, 13};
Circle(13) = {13, 23, 14};
Circle(14) = {14, 24, 15};
Line(15) = {15, 16};
Line(16) = {16, 1};
Curve Loop(1) = {1:16};
Plane Surface(1) = {1};
specimen[] = Extrude {0, 4, 0} { Surface{1}; };
Physical Volume("specimen") = {specimen[1]};
