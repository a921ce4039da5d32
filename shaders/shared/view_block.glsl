/* Members of the uniform block `View`, the same list in C and GLSL (src/render/blocks.h, shaders/lib/view.glsl).
   "Meridian frame": ECEF turned about z so that the focus of the rings lies on its x-z plane; origin at the camera.
   "Tangent frame": that turned about y so that x is up at the focus, y east, z north. */
BLOCK_MAT4(clip_from_tangent) /* reverse-Z, no far plane: depth = near / distance along the view axis */
BLOCK_VEC4(ray_centre)         /* view ray at NDC (x, y): ray_centre + x ray_right + y ray_up; 1 along the view axis */
BLOCK_VEC4(ray_right)
BLOCK_VEC4(ray_up)
BLOCK_VEC4(focus)              /* cos b, sin b of the reduced latitude b; A/B; geodetic latitude */
BLOCK_VEC4(focus_paper)        /* b; stretch of eq. 11; d(lat)/db; blend weight of level 0 of the paper's blend */
BLOCK_VEC4(axes)               /* A, B (m); by how many levels a ring's heights are finer than its own level; - */
BLOCK_VEC4(place_scale)        /* the members of place_frame (shared/position.glsl), in order */
BLOCK_VEC4(place_shape)
BLOCK_VEC4(place_up)
BLOCK_VEC4(place_along)
BLOCK_VEC4(camera)             /* camera from the planet's centre, in units of A, A, B; w: its distance minus 1 */
BLOCK_VEC4(sun)                /* unit vector to the sun, meridian frame; w: cos of the focus's longitude */
BLOCK_VEC4(atmosphere)         /* 1 / scale height in planet radii; radius / scale height; glow strength; sin of longitude */
BLOCK_VEC4(screen)             /* width, height (px); near plane (m); angle of one pixel (rad) */
BLOCK_VEC4(map_edge)           /* of a plane: south, north, west, east end of the map as n~ and e~ */
BLOCK_UVEC4(rings)             /* coarsest and finest drawn level; rings a level; columns a ring */
BLOCK_UVEC4(layers)            /* finest height level and finest colour level of the windows */
