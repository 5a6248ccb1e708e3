/* What the program needs of the platform: output, and a start that calls it. */
#ifndef PLATFORM_H
#define PLATFORM_H

/* Prints a text. */
void say(const char *text);

/* Runs the program; 0 is a success. */
int program(void);

#endif
