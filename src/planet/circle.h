// A raster of longitudes that goes all the way round, turned and closed for GDAL's warper, which
// knows of no circle: PROJ gives it longitudes within 180 degrees, wherever the raster begins.
#ifndef PERIGEE_PLANET_CIRCLE_H
#define PERIGEE_PLANET_CIRCLE_H

// Of a GDAL dataset one of the VRT format from 180 W to 180 E and a few columns more at either end,
// with its mask and coverage; it holds on to the dataset and has no overviews. NULL when the
// dataset is no whole circle. Released by the caller. As thread-safe as the dataset.
void *circle_close(void *dataset);

#endif
