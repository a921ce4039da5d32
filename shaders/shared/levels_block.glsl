/* Members of the uniform block `Levels`: where the windows of each level lie, for heights (and normals) and for colour.
   Sample coordinates count rows southward and columns eastward from the held window's first sample. */
BLOCK_VEC4_ARRAY(height_map, 24)   /* rows a radian, columns a radian; the focus's row and column */
BLOCK_VEC4_ARRAY(height_torus, 24) /* texture row and column of the window's first sample; fade in [0, 1]; 1 where its share is about to change */
BLOCK_VEC4_ARRAY(height_valid, 24) /* rows [x, y), columns [z, w) that may be sampled */
BLOCK_VEC4_ARRAY(color_map, 24)
BLOCK_VEC4_ARRAY(color_torus, 24)
BLOCK_VEC4_ARRAY(color_valid, 24)
