// A disc of 75 mm, 2.8 mm from molecule to molecule; gmsh -2 -format msh41 disc.geo
radius = 37.5;
Point(1) = {0, 0, 0, 2.8};
Point(2) = {radius, 0, 0, 2.8};
Point(3) = {0, radius, 0, 2.8};
Point(4) = {-radius, 0, 0, 2.8};
Point(5) = {0, -radius, 0, 2.8};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Circle(3) = {4, 1, 5};
Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Surface("membrane") = {1};
