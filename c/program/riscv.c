/* The program on an emulated RISC-V: start-up, and output by semihosting ("RISC-V Semihosting":
 * operation in a0, argument in a1, EBREAK between two instructions that do nothing). */
#include <stdint.h>

#include "platform.h"

enum { WRITE0 = 0x04, EXIT = 0x18, APPLICATION_EXIT = 0x20026, RUN_TIME_ERROR = 0x20023 };

static void semihosting(uint32_t operation, const void *argument) {
    register uint32_t a0 __asm__("a0") = operation;
    register const void *a1 __asm__("a1") = argument;
    __asm__ volatile(".balign 16\n"
                     ".option push\n"
                     ".option norvc\n"
                     "slli x0, x0, 0x1f\n"
                     "ebreak\n"
                     "srai x0, x0, 7\n"
                     ".option pop"
                     : "+r"(a0)
                     : "r"(a1)
                     : "memory");
}

void say(const char *text) {
    semihosting(WRITE0, text);
}

/* Called with a stack, in memory that the emulator has loaded and cleared. */
void start(void) {
    int result = program();
    semihosting(EXIT, (const void *)(result == 0 ? APPLICATION_EXIT : RUN_TIME_ERROR));
    for (;;) {
    }
}

/* The emulator enters here. */
__asm__(".section .entry, \"ax\"\n"
        ".globl entry\n"
        "entry:\n"
        "la sp, stack_top\n"
        "j start\n");
