// The import proper, from inputs that may also be grids in memory; import_run and import_earth are
// its callers.
#ifndef PERIGEE_PLANET_IMPORT_INPUTS_H
#define PERIGEE_PLANET_IMPORT_INPUTS_H

#include "planet/import_raster.h"

// As import_run, but the sources come from `inputs`; params->sources is not looked at. `made_from`
// is added to the fingerprint: it must tell grids in memory apart.
status import_inputs(const import_params *params, const import_input *inputs, int count,
                     const char *made_from);

// The checks that import_inputs makes first, for a caller with long work before it: ERR_ARGUMENT
// when the output exists and may not be replaced, ERR_IO when it cannot be written.
status import_check_output(const char *output, bool force);

#endif
