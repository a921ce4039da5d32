/* Members of the persistent grid's buffer, the same list in C and GLSL (src/geo/screen_grid.h, shaders/lib/grid.glsl). Points
   and directions: u, e, n, the axes of the focus (outwards, east, north) in the space where the ellipsoid is the unit sphere. */
BLOCK_DVEC4(foot)         /* unit vector under the camera; its cosine to `up`. On a plane 0 and its place from the focus */
BLOCK_DVEC4(up)           /* unit vector along the vertical under the camera; its length a metre */
BLOCK_DVEC4(axis)         /* unit vector to the camera lowered to the farthest base; camera's height (m) */
BLOCK_DVEC4(row_axis)     /* upwards in the sampling camera's picture, a unit of y; half the picture's height */
BLOCK_DVEC4(limb)         /* cotangents of the angle from `axis` at the limb and where the grid ends; tangent of the angle past */
                          /* the limb there; how much denser the middle is, 0 to 1 */
BLOCK_DVEC4_ARRAY(base, 26) /* growing cotangents of the angle from `axis`, height of the base there (m); knots in all; 1, and 0 on a plane */
