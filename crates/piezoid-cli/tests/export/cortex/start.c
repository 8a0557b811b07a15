/* What a board does before main, and a count of instructions: with `-icount shift=0` an instruction is a nanosecond, and
   SysTick, which counts the processor's clock of 25 MHz, one of 40. */
#include <stdint.h>

extern uint32_t data_kept, data_begins, data_ends, zero_begins, zero_ends, stack_begins;
extern void initialise_monitor_handles(void);
extern int main(void);
extern void exit(int);

void _init(void) {}
void _fini(void) {}

static void stuck(void)
{
    for (;;) {
    }
}

void start(void)
{
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* the floating-point unit on */
    uint32_t *from = &data_kept;
    for (uint32_t *to = &data_begins; to < &data_ends; to++) {
        *to = *from++;
    }
    for (uint32_t *to = &zero_begins; to < &zero_ends; to++) {
        *to = 0;
    }
    *(volatile uint32_t *)0xE000E014 = 0xFFFFFF;
    *(volatile uint32_t *)0xE000E018 = 0;
    *(volatile uint32_t *)0xE000E010 = 5; /* the processor's clock, no interrupt */
    initialise_monitor_handles();
    exit(main());
}

uint32_t ticks(void)
{
    return 0xFFFFFF - *(volatile uint32_t *)0xE000E018; /* of 24 bits */
}

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void)) & stack_begins, start, stuck, stuck, stuck, stuck, stuck, stuck, stuck, stuck, stuck, stuck, stuck, stuck, stuck, stuck,
};
