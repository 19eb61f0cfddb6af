/* The C that cantools generates, as bench.py measures it: codec WORK SECONDS
   prints millions of frames a second. */
#include "bench.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { FRAMES = 1024 };
static uint8_t frames[FRAMES][8];

static double now_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double decode_feedback(const uint8_t *frame) {
    struct bench_feedback_t message;
    bench_feedback_unpack(&message, frame, 8);
    return bench_feedback_position_decode(message.position) +
           bench_feedback_torque_applied_decode(message.torque_applied) + bench_feedback_state_decode(message.state) +
           bench_feedback_counter_decode(message.counter) + bench_feedback_temperature_decode(message.temperature);
}

static double encode_feedback(uint8_t *frame, int i) {
    struct bench_feedback_t message;
    message.position = bench_feedback_position_encode(1000.0 * i);
    message.torque_applied = bench_feedback_torque_applied_encode(0.1 * i);
    message.state = bench_feedback_state_encode(i & 15);
    message.counter = bench_feedback_counter_encode(i & 15);
    message.temperature = bench_feedback_temperature_encode(20.0);
    bench_feedback_pack(frame, &message, 8);
    return frame[0];
}

static double decode_measured(const uint8_t *frame) {
    struct bench_measured_t message;
    bench_measured_unpack(&message, frame, 8);
    double sum = bench_measured_kind_decode(message.kind) + bench_measured_always_decode(message.always);
    switch (message.kind) {
    case 0: return sum + bench_measured_speed_decode(message.speed);
    case 1:
        return sum + bench_measured_current_decode(message.current) + bench_measured_voltage_decode(message.voltage);
    default: return sum + bench_measured_energy_decode(message.energy);
    }
}

static double encode_measured(uint8_t *frame, int i) {
    struct bench_measured_t message;
    message.kind = bench_measured_kind_encode(i % 3);
    message.always = bench_measured_always_encode(20.0);
    switch (message.kind) {
    case 0: message.speed = bench_measured_speed_encode(0.1 * i); break;
    case 1:
        message.current = bench_measured_current_encode(0.01 * i);
        message.voltage = bench_measured_voltage_encode(48.0);
        break;
    default: message.energy = bench_measured_energy_encode(100.0 * i);
    }
    bench_measured_pack(frame, &message, 8);
    return frame[0];
}

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    const char *work = argv[1];
    double limit_s = atof(argv[2]), sum = 0.0, begun_s = now_s();
    long done = 0;
    for (int i = 0; i < FRAMES; i++)
        if (strstr(work, "measured")) encode_measured(frames[i], i);
        else encode_feedback(frames[i], i);
    do {
        for (int i = 0; i < FRAMES; i++) {
            if (!strcmp(work, "decode-feedback")) sum += decode_feedback(frames[i]);
            else if (!strcmp(work, "encode-feedback")) sum += encode_feedback(frames[i], i);
            else if (!strcmp(work, "decode-measured")) sum += decode_measured(frames[i]);
            else if (!strcmp(work, "encode-measured")) sum += encode_measured(frames[i], i);
            else return 2;
        }
        done += FRAMES;
    } while (now_s() - begun_s < limit_s);
    printf("%.3f\n", 1e-6 * (double)done / (now_s() - begun_s));
    return sum == 0.125; /* uses the sum */
}
