/* The program on a computer. */
#include <stdio.h>

#include "platform.h"

void say(const char *text) {
    fputs(text, stdout);
}

int main(void) {
    return program();
}
