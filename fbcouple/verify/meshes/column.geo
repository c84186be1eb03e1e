// A round column about its own axis: prisms below, tetrahedra above, on one face in common.
// column.msh is made of it: gmsh -3 -nt 1 -format msh41 -o column.msh column.geo
r = 0.01; h = 0.022; lc = 0.0027;
Point(1) = {0, 0, 0, lc}; Point(2) = {r, 0, 0, lc}; Point(3) = {0, r, 0, lc}; Point(4) = {-r, 0, 0, lc}; Point(5) = {0, -r, 0, lc};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
low[] = Extrude {0, 0, h} { Surface{1}; Layers{9}; Recombine; };
high[] = Extrude {0, 0, h} { Surface{low[0]}; };
Physical Surface("bottom") = {1};
Physical Surface("top") = {high[0]};
Physical Volume("bed") = {low[1], high[1]};
