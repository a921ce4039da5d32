// Layers of the texture arrays of heights, normals and convexity, and of the planar mode's elevation maps. Levels have one
// each, but fleeting ones, of which only the last few made are there (src/render/fleeting.h): those take turns.
#ifdef KEPT_LEVELS
int window_layer(int level)
{
    return level < KEPT_LEVELS ? level : KEPT_LEVELS + level % 2;
}

int convexity_layer(int level)
{
    return level < KEPT_LEVELS ? level : KEPT_LEVELS + level % 5;
}
#else
int window_layer(int level)
{
    return level;
}

int convexity_layer(int level)
{
    return level;
}
#endif

#ifdef KEPT_ELEVATIONS
int elevation_layer(int level)
{
    return level < KEPT_ELEVATIONS ? level : KEPT_ELEVATIONS + level % 2;
}
#else
int elevation_layer(int level)
{
    return level;
}
#endif
