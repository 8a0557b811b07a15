/* What stands at the end in code that Simulink Coder compiles. */
#include "simulink.c"
