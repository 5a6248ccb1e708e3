/* The program on an emulated Cortex-M: start-up, and output by semihosting (Arm's "Semihosting for
 * AArch32 and AArch64": operation in r0, argument in r1, BKPT 0xAB). */
#include <stdint.h>

#include "platform.h"

enum { WRITE0 = 0x04, EXIT = 0x18, APPLICATION_EXIT = 0x20026, RUN_TIME_ERROR = 0x20023 };

extern uint32_t stack_top, data_from, data_start, data_end, bss_start, bss_end;

static void semihosting(uint32_t operation, const void *argument) {
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

void say(const char *text) {
    semihosting(WRITE0, text);
}

static void end(int result) {
    semihosting(EXIT, (const void *)(result == 0 ? APPLICATION_EXIT : RUN_TIME_ERROR));
    for (;;) {
    }
}

static void fault(void) {
    say("fault\n");
    end(1);
}

void reset(void) {
#ifdef __ARM_FP
    /* Full access to the floating-point unit: CP10 and CP11 in CPACR (ARMv7-M, B3.2.20). */
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20;
    __asm__ volatile("dsb\n isb");
#endif
    uint32_t *from = &data_from;
    for (uint32_t *to = &data_start; to < &data_end; to++) {
        *to = *from++;
    }
    for (uint32_t *to = &bss_start; to < &bss_end; to++) {
        *to = 0;
    }
    end(program());
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    &stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};
