/* The part of Arduino that SimpleFOC's motor, sensor and controllers use, on a computer. Time is
 * that of the simulated joint: each thread runs one joint. */
#ifndef ARDUINO_H
#define ARDUINO_H

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

using std::abs;
using std::isnan;
using std::max;
using std::min;

typedef bool boolean;
typedef uint8_t byte;

#define HIGH 1
#define LOW 0
#define PROGMEM

class __FlashStringHelper;
#define F(text) (reinterpret_cast<const __FlashStringHelper *>(text))

class Print {
  public:
    template <typename... T> void print(T...) {}
    template <typename... T> void println(T...) {}
};

typedef const char *StringSumHelper;

/* Time of the joint, us. */
extern thread_local uint32_t simulated_micros;

static inline unsigned long micros() { return simulated_micros; }
static inline unsigned long millis() { return simulated_micros / 1000; }
static inline void delay(unsigned long ms) { simulated_micros += 1000 * ms; }
static inline void delayMicroseconds(unsigned int us) { simulated_micros += us; }

#endif
