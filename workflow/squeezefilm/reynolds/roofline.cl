/* The device's limits and the solver's parts, each repeated, to set one beside the other.
 * Compiled after linear_algebra.cl, vectors.cl and grid_over_period.cl. */

/* Twelve independent chains of multiply-adds in registers: 2 · 12 · LANES flop a turn and work-item.
 * They are written out, for a compiler may keep an array in memory. */
#define TWELVE(STEP) \
    STEP(0) STEP(1) STEP(2) STEP(3) STEP(4) STEP(5) STEP(6) STEP(7) STEP(8) STEP(9) STEP(10) STEP(11)
#define START(i) lanes sum##i = start + (double)i;
#define TURN(i) sum##i = sum##i * factor + start;
#define ADD(i) + sum##i

__kernel void multiply_add_peak(const int turns, field out)
{
    /* As it is loaded: a function that returns a register makes LLVM use it (vectors.cl). */
    const lanes start = loaded(out), factor = (lanes)(0.999999);
    TWELVE(START)
    for (int turn = 0; turn < turns; turn++) {
        TWELVE(TURN)
    }
    out[get_global_id(0)] = sum_of_lanes((lanes)(0.0) TWELVE(ADD));
}

/* c = a + 3 b over each group's own stretch of memory: 24 bytes a number. */
__kernel void stream_triad(const int count4, const int turns, field4 a, field4 b, field4 c)
{
    const size_t start = get_group_id(0) * (size_t)count4;
    for (int turn = 0; turn < turns; turn++) {
        FOR_EACH(i, count4) c[start + i] = a[start + i] + 3.0 * b[start + i];
        SYNC;
    }
}

/* The solver's products, `turns` times, on each group's own two fields. */
__kernel void panel_products(const int which, const int turns, __global const Row *row,
                             matrix values, field workspace)
{
    vector none = workspace;
    const Grid g = make_grid(row, values, &none);
    field in = workspace + get_group_id(0) * (size_t)(2 * g.count), out = in + g.count;
    for (int turn = 0; turn < turns; turn++) {
        if (which == 0)
            mirrored_x(&g, g.whole_x, g.laplace_x, in, out, NODES_TO_NODES, 0);
        else if (which == 1)
            mirrored_y(&g, g.laplace_y, in, out, NODES_TO_NODES, 0);
        else
            along_t(&g, g.linear.time_modes, in, out, 0);
    }
}
