// Ctrl-C as a question asked between steps of long work. Main only.
#ifndef PERIGEE_APP_INTERRUPT_H
#define PERIGEE_APP_INTERRUPT_H

#include <stdbool.h>

// From now on the first SIGINT or SIGTERM only sets the flag; a second one ends the program as
// usual.
void interrupt_catch(void);
bool interrupt_requested(void);

#endif
