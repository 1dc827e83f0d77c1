/* Dense products and sums of one number type, by the work-items of one work-group. Compiled for
 * doubles, and again for floats where GMRES works in single precision (SINGLE): what is compiled
 * behind that takes `real` for them.
 *
 * A field is stored [x][y][t] with time innermost, so that every operator of the solver is a
 * small matrix times panels of contiguous numbers. Numbers of columns are multiples of four, those of
 * rows even. The device says how many doubles or floats its registers hold (device.py).
 */
#ifndef real
#define real double
#define LANES DOUBLE_LANES
#else
#undef real
#undef LANES
#define real float
#define LANES FLOAT_LANES
#endif

#ifndef VECTORS
#define VECTORS
#define JOINED(a, b) a##b
#define JOIN(a, b) JOINED(a, b)
/* Of the type that is `real` where they stand: vectors in memory, and as many as a register holds. */
#define vector JOIN(real, _vector)
#define constant_vector JOIN(constant_, vector)
#define lanes JOIN(real, LANES)
/* Processors with registers of 64 bytes have 32 of them. */
#if DOUBLE_LANES == 8
#define MANY_REGISTERS
#endif
#define OF_BOTH_TYPES static __attribute__((overloadable))
/* Functions without barriers that every product calls: where PoCL copies those with barriers to each of
 * their calls, these are not copied with them, which took minutes. */
#if WORK_ITEMS == 1
#define BLOCKS_OF_BOTH_TYPES OF_BOTH_TYPES inline
#else
#define BLOCKS_OF_BOTH_TYPES OF_BOTH_TYPES __attribute__((noinline))
#endif

/* c = a b (+ c) for 2 to 16 rows over 1 to 4 registers, of the last of which `last` numbers are stored.
 * `a*b + c` is contracted to a fused multiply-add; an explicit fma() is slow on PoCL. */
#define ROWS_2(STEP, w) STEP(0, w) STEP(1, w)
#define ROWS_3(STEP, w) ROWS_2(STEP, w) STEP(2, w)
#define ROWS_4(STEP, w) ROWS_3(STEP, w) STEP(3, w)
#define ROWS_5(STEP, w) ROWS_4(STEP, w) STEP(4, w)
#define ROWS_8(STEP, w) ROWS_4(STEP, w) STEP(4, w) STEP(5, w) STEP(6, w) STEP(7, w)
#define ROWS_16(STEP, w) ROWS_8(STEP, w) STEP(8, w) STEP(9, w) STEP(10, w) STEP(11, w) \
    STEP(12, w) STEP(13, w) STEP(14, w) STEP(15, w)
#define ONE_ROW(STEP, w) STEP(0, w)
#define WIDE_1(ROWS, STEP) ROWS(STEP, 0)
#define WIDE_2(ROWS, STEP) WIDE_1(ROWS, STEP) ROWS(STEP, 1)
#define WIDE_3(ROWS, STEP) WIDE_2(ROWS, STEP) ROWS(STEP, 2)
#define WIDE_4(ROWS, STEP) WIDE_3(ROWS, STEP) ROWS(STEP, 3)
#define LOAD(i, w) lanes c##i##w = add ? loaded(c + i * columns + w * LANES) : (lanes)(0);
#define ENTRY(i, w) const real a##i = a[i * inner + k];
#define READ(i, w) const lanes b##w = loaded(row + w * LANES);
#define MULTIPLY(i, w) c##i##w += a##i * b##w;
#define STORE(i, w) store(c##i##w, c + i * columns + w * LANES, w < wide - 1 ? LANES : last);
#define BLOCK(name, rows, registers)                                                           \
    BLOCKS_OF_BOTH_TYPES void name(constant_vector a, int inner, constant_vector b, vector c,  \
                                   int columns, int last, int add)                             \
    {                                                                                          \
        const int wide = registers;                                                            \
        WIDE_##registers(ROWS_##rows, LOAD)                                                    \
        for (int k = 0; k < inner; k++) {                                                      \
            constant_vector row = b + k * columns;                                             \
            WIDE_##registers(ONE_ROW, READ)                                                    \
            ROWS_##rows(ENTRY, 0)                                                              \
            WIDE_##registers(ROWS_##rows, MULTIPLY)                                            \
        }                                                                                      \
        WIDE_##registers(ROWS_##rows, STORE)                                                   \
    }

/* Products with a matrix that commutes with mirroring, or as a derivative changes its sign with it
 * (`to_nodes` below zero), kept as its even and its odd part of half the size. Of b and c the values at
 * a node and at its mirror image are the k-th row from the first and the k-th from the last on; the
 * coefficients of an even and an odd mode likewise. */
#define NONE(i, w) lanes e##i##w = (lanes)(0), o##i##w = (lanes)(0);
#define PARTS(i, w)                                                               \
    const lanes x##w = loaded(row + w * LANES), y##w = loaded(image + w * LANES); \
    const lanes s##w = of_nodes ? x##w + y##w : x##w, d##w = of_nodes ? x##w - y##w : y##w;
#define ENTRIES(i, w) const real a##i = even[i * half_rows + k], b##i = odd[i * half_rows + k];
#define MULTIPLY_PARTS(i, w) e##i##w += a##i * s##w; o##i##w += b##i * d##w;
#define STORE_PARTS(i, w)                                                                       \
    {                                                                                           \
        vector top = c + i * columns + w * LANES, bottom = mirrored - i * columns + w * LANES; \
        const int count = w < wide - 1 ? LANES : last;                                          \
        const lanes first = to_nodes ? e##i##w + o##i##w : e##i##w;                             \
        const lanes second =                                                                    \
            to_nodes > 0 ? e##i##w - o##i##w : to_nodes ? o##i##w - e##i##w : o##i##w;          \
        store(add ? loaded(top) + first : first, top, count);                                   \
        store(add ? loaded(bottom) + second : second, bottom, count);                           \
    }
#define MIRRORED_BLOCK(name, rows, registers)                                                     \
    OF_BOTH_TYPES inline void name(constant_vector even, constant_vector odd, int half_rows,           \
                                   constant_vector b, vector c, vector mirrored, int columns,     \
                                   int last, const int of_nodes, const int to_nodes, int add)     \
    {                                                                                             \
        const int wide = registers;                                                               \
        WIDE_##registers(ROWS_##rows, NONE)                                                       \
        for (int k = 0; k < half_rows; k++) {                                                          \
            constant_vector row = b + k * columns, image = b + (2 * half_rows - 1 - k) * columns;      \
            WIDE_##registers(ONE_ROW, PARTS)                                                      \
            ROWS_##rows(ENTRIES, 0)                                                               \
            WIDE_##registers(ROWS_##rows, MULTIPLY_PARTS)                                         \
        }                                                                                         \
        WIDE_##registers(ROWS_##rows, STORE_PARTS)                                                \
    }
/* Registers beside each other whose columns stay in the first cache for all rows. */
#ifdef MANY_REGISTERS
#define STRIPE 2
#else
#define STRIPE 1
#endif
/* What such a matrix takes to what. */
#define NODES_TO_NODES 0
#define NODES_TO_MODES 1
#define MODES_TO_NODES 2
#define NODES_TO_SLOPES 3
#endif

typedef __global real *vector;
typedef __global const real *constant_vector;
/* A register of numbers, and the first `count` of one stored; places are those of four numbers each.
 * PoCL's vload and vstore are calls that it does not expand; and a function that returns a register
 * makes LLVM take them as wide, where it prefers half of them. */
#if LANES > 4
typedef struct __attribute__((packed)) { lanes numbers; } JOIN(unaligned_, real);
#if LANES == 16
typedef struct __attribute__((packed)) { JOIN(real, 8) numbers; } JOIN(half_, real);
#endif
#else
typedef struct { lanes numbers; } JOIN(unaligned_, real);
#endif

OF_BOTH_TYPES inline lanes loaded(constant_vector place)
{
    return ((__global const JOIN(unaligned_, real) *)place)->numbers;
}

OF_BOTH_TYPES inline void store(lanes values, vector place, int count)
{
    if (count >= LANES) {
        ((__global JOIN(unaligned_, real) *)place)->numbers = values;
        return;
    }
#if LANES == 8
    *(__global JOIN(real, 4) *)place = values.lo;
#elif LANES == 16
    /* A half at a time: most grids have 8 or 12 instants. */
    if (count == 4) {
        *(__global JOIN(real, 4) *)place = values.lo.lo;
        return;
    }
    ((__global JOIN(half_, real) *)place)->numbers = values.lo;
    if (count > 8)
        ((__global JOIN(real, 4) *)place)[2] = values.hi.lo;
#endif
}

BLOCK(block_2_1, 2, 1)
BLOCK(block_4_1, 4, 1)
#if WORK_ITEMS == 1
BLOCK(block_2_2, 2, 2)
BLOCK(block_2_3, 2, 3)
BLOCK(block_2_4, 2, 4)
BLOCK(block_4_2, 4, 2)
BLOCK(block_4_3, 4, 3)
BLOCK(block_4_4, 4, 4)
#endif
#ifdef MANY_REGISTERS
BLOCK(block_8_1, 8, 1)
BLOCK(block_8_2, 8, 2)
BLOCK(block_16_1, 16, 1)
#endif

#if WORK_ITEMS == 1
/* Four rows of a panel, or two. */
#define FOUR_OR_TWO(registers)                                           \
    if (rows == 4)                                                       \
        block_4_##registers(a, inner, from_b, to_c, columns, last, add); \
    else                                                                 \
        block_2_##registers(a, inner, from_b, to_c, columns, last, add);
BLOCKS_OF_BOTH_TYPES void some_rows(constant_vector a, int rows, int inner, constant_vector b, vector c,
                                    int columns, int add)
{
    for (int column = 0; column < columns;) {
        const int left = (columns - column + LANES - 1) / LANES;
        /* Never one alone beside others, which is slow. */
        const int width = left == 5 ? 3 : min(left, 4), last = columns - column - (width - 1) * LANES;
        constant_vector from_b = b + column;
        vector to_c = c + column;
        switch (width) {
        case 4: FOUR_OR_TWO(4) break;
        case 3: FOUR_OR_TWO(3) break;
        case 2: FOUR_OR_TWO(2) break;
        default: FOUR_OR_TWO(1)
        }
        column += width * LANES;
    }
}
#endif

#ifdef MANY_REGISTERS
/* Eight rows of a panel. */
OF_BOTH_TYPES inline void eight_rows(constant_vector a, int inner, constant_vector b, vector c,
                                     int columns, int add)
{
    int column = 0;
    for (; columns - column > LANES; column += 2 * LANES)
        block_8_2(a, inner, b + column, c + column, columns, columns - column - LANES, add);
    if (column < columns)
        block_8_1(a, inner, b + column, c + column, columns, columns - column, add);
}
#endif

/* c = a b (+ c) for some panels of b and c, (inner, columns) and (rows, columns) numbers behind each
 * other: a is (rows, inner). Of b up to a register more is read, and not used: behind every array there
 * is room for that. */
OF_BOTH_TYPES void product(constant_vector a, int rows, int inner, constant_vector b, vector c,
                           int columns, int panels, int add)
{
    const int panel_b = inner * columns, panel_c = rows * columns;
#if WORK_ITEMS == 1
    for (int p = 0; p < panels; p++, b += panel_b, c += panel_c) {
        int row = 0;
#ifdef MANY_REGISTERS
        if (columns <= LANES)
            for (; rows - row >= 16; row += 16)
                block_16_1(a + row * inner, inner, b, c + row * columns, columns, columns, add);
        for (; rows - row >= 8; row += 8)
            eight_rows(a + row * inner, inner, b, c + row * columns, columns, add);
#endif
        for (; row < rows; row += 4)
            some_rows(a + row * inner, min(rows - row, 4), inner, b, c + row * columns, columns, add);
    }
#else
    const int row_blocks = (rows + 3) / 4, column_blocks = (columns + LANES - 1) / LANES;
    FOR_EACH(task, panels * row_blocks * column_blocks)
    {
        const int p = task / (row_blocks * column_blocks);
        const int row = 4 * (task / column_blocks % row_blocks);
        const int column = LANES * (task % column_blocks);
        constant_vector of_a = a + row * inner, from_b = b + p * panel_b + column;
        vector to_c = c + p * panel_c + row * columns + column;
        if (rows - row >= 4)
            block_4_1(of_a, inner, from_b, to_c, columns, columns - column, add);
        else
            block_2_1(of_a, inner, from_b, to_c, columns, columns - column, add);
    }
#endif
}

OF_BOTH_TYPES void multiply(constant_vector a, int rows, int inner, constant_vector b, vector c,
                            int columns, int panels, int add)
{
    product(a, rows, inner, b, c, columns, panels, add);
    SYNC;
}

MIRRORED_BLOCK(mirrored_5_1, 5, 1)
MIRRORED_BLOCK(mirrored_4_1, 4, 1)
MIRRORED_BLOCK(mirrored_3_1, 3, 1)
MIRRORED_BLOCK(mirrored_2_1, 2, 1)
#ifdef MANY_REGISTERS
MIRRORED_BLOCK(mirrored_8_1, 8, 1)
MIRRORED_BLOCK(mirrored_5_2, 5, 2)
MIRRORED_BLOCK(mirrored_4_2, 4, 2)
MIRRORED_BLOCK(mirrored_3_2, 3, 2)
MIRRORED_BLOCK(mirrored_2_2, 2, 2)
#endif

/* Four rows of the first half of a panel, or its last two, three or five, and their mirror images,
 * from column `from` up to `to`. */
#define MIRRORED_ROWS(rows, registers)                                                              \
    mirrored_##rows##_##registers(even, odd, half_rows, b + column, top + column, bottom + column, \
                                  columns, last, of_nodes, to_nodes, add);
#define MIRRORED_SWITCH(registers)                     \
    switch (half_rows - row) {                         \
    case 5: MIRRORED_ROWS(5, registers) break;         \
    case 3: MIRRORED_ROWS(3, registers) break;         \
    case 2: MIRRORED_ROWS(2, registers) break;         \
    default: MIRRORED_ROWS(4, registers)               \
    }
#define MIRRORED_ROW_BLOCKS(half_rows) (((half_rows) + 2) / 4)
BLOCKS_OF_BOTH_TYPES void mirrored_rows(constant_vector a, int half_rows, int row, constant_vector b,
                                        vector c, int columns, int from, int to, const int of_nodes,
                                        const int to_nodes, int add)
{
    constant_vector even = a + row * half_rows, odd = even + half_rows * half_rows;
    vector top = c + row * columns, bottom = c + (2 * half_rows - 1 - row) * columns;
    int column = from;
#ifdef MANY_REGISTERS
    for (; to - column > LANES; column += 2 * LANES) {
        const int last = to - column - LANES;
        MIRRORED_SWITCH(2)
    }
#endif
    for (; column < to; column += LANES) {
        const int last = to - column;
        MIRRORED_SWITCH(1)
    }
}

/* c = a b (+ c) as by `product`, for a matrix of twice so many rows and columns that commutes with
 * mirroring: a is (2, half_rows, half_rows). Half as many multiplications. */
OF_BOTH_TYPES inline void product_of_parts(constant_vector a, int half_rows, constant_vector b, vector c,
                                         int columns, int panels, const int of_nodes,
                                         const int to_nodes, int add)
{
    const int panel = 2 * half_rows * columns;
#if WORK_ITEMS == 1
    for (int p = 0; p < panels; p++, b += panel, c += panel)
        for (int column = 0; column < columns; column += STRIPE * LANES) {
            int row = 0;
#ifdef MANY_REGISTERS
            if (columns <= LANES)
                for (; half_rows - row >= 8 && half_rows - row != 9; row += 8)
                    mirrored_8_1(a + row * half_rows, a + (half_rows + row) * half_rows, half_rows, b,
                                 c + row * columns, c + (2 * half_rows - 1 - row) * columns, columns,
                                 columns, of_nodes, to_nodes, add);
#endif
            for (; half_rows - row > 1; row += 4)
                mirrored_rows(a, half_rows, row, b, c, columns, column,
                              min(column + STRIPE * LANES, columns), of_nodes, to_nodes, add);
        }
#else
    const int row_blocks = MIRRORED_ROW_BLOCKS(half_rows);
    const int column_blocks = (columns + LANES - 1) / LANES;
    FOR_EACH(task, panels * row_blocks * column_blocks)
    {
        const int p = task / (row_blocks * column_blocks);
        const int row = 4 * (task / column_blocks % row_blocks);
        const int column = LANES * (task % column_blocks);
        mirrored_rows(a, half_rows, row, b + p * panel, c + p * panel, columns, column,
                      min(column + LANES, columns), of_nodes, to_nodes, add);
    }
#endif
}

OF_BOTH_TYPES void mirrored_product(constant_vector a, int half_rows, constant_vector b, vector c,
                                     int columns, int panels, int kind, int add)
{
#if WORK_ITEMS == 1
    switch (kind) {
    case NODES_TO_NODES: product_of_parts(a, half_rows, b, c, columns, panels, 1, 1, add); break;
    case NODES_TO_MODES: product_of_parts(a, half_rows, b, c, columns, panels, 1, 0, add); break;
    case NODES_TO_SLOPES: product_of_parts(a, half_rows, b, c, columns, panels, 1, -1, add); break;
    default: product_of_parts(a, half_rows, b, c, columns, panels, 0, 1, add);
    }
#else
    /* One of them: what compilers inline is as long as it must be. */
    product_of_parts(a, half_rows, b, c, columns, panels, kind != MODES_TO_NODES,
                   kind == NODES_TO_MODES ? 0 : kind == NODES_TO_SLOPES ? -1 : 1, add);
#endif
}

/* Four numbers as doubles, and doubles in a vector: PoCL's own conversions are calls, too. */
OF_BOTH_TYPES double4 in_double(JOIN(real, 4) v) { return (double4)(v.x, v.y, v.z, v.w); }
OF_BOTH_TYPES void store4(double4 v, int i, vector to)
{
    ((__global JOIN(real, 4) *)to)[i] = (JOIN(real, 4))(v.x, v.y, v.z, v.w);
}

/* Each pair's two numbers the other way round. */
OF_BOTH_TYPES inline lanes pairs_swapped(lanes v)
{
#if LANES == 16
    return v.s1032547698badcfe;
#elif LANES == 8
    return v.s10325476;
#else
    return v.s1032;
#endif
}

OF_BOTH_TYPES double sum_of_lanes(lanes v)
{
#if LANES == 16
    const float8 two = v.lo + v.hi;
    return sum_of(in_double(two.lo + two.hi));
#elif LANES == 8
    return sum_of(in_double(v.lo + v.hi));
#else
    return sum_of(in_double(v));
#endif
}

OF_BOTH_TYPES double dot_product(constant_vector a, constant_vector b, int count4,
                                 __local double *scratch)
{
    __global const lanes *a_lanes = (__global const lanes *)a, *b_lanes = (__global const lanes *)b;
    lanes even = (lanes)(0), odd = (lanes)(0);
    FOR_EACH(i, count4 / (LANES / 2))
    {
        even += a_lanes[2 * i] * b_lanes[2 * i];
        odd += a_lanes[2 * i + 1] * b_lanes[2 * i + 1];
    }
#if LANES == 16
    if (count4 / 4 % 2)
        even += a_lanes[count4 / 4 - 1] * b_lanes[count4 / 4 - 1];
#endif
    return sum_over_group(sum_of_lanes(even + odd), scratch);
}

/* Root of the sum of squares over `weight`; the squares of small floats are none. */
OF_BOTH_TYPES double norm(constant_vector a, int count4, double weight, __local double *scratch)
{
    __global const JOIN(real, 4) *a4 = (__global const JOIN(real, 4) *)a;
    double4 even = (double4)(0.0), odd = (double4)(0.0);
    FOR_EACH(i, count4 / 2)
    {
        const double4 first = in_double(a4[2 * i]), second = in_double(a4[2 * i + 1]);
        even += first * first;
        odd += second * second;
    }
    return sqrt(sum_over_group(sum_of(even + odd), scratch) / weight);
}

/* a −= scale b, and the dot product of the new a with c: one pass over a instead of two. */
OF_BOTH_TYPES double subtract_and_project(vector a, real scale, constant_vector b, constant_vector c,
                                          int count4, __local double *scratch)
{
    __global lanes *a_lanes = (__global lanes *)a;
    __global const lanes *b_lanes = (__global const lanes *)b, *c_lanes = (__global const lanes *)c;
    lanes even = (lanes)(0), odd = (lanes)(0);
    FOR_EACH(i, count4 / (LANES / 2))
    {
        const lanes first = a_lanes[2 * i] - scale * b_lanes[2 * i];
        const lanes second = a_lanes[2 * i + 1] - scale * b_lanes[2 * i + 1];
        a_lanes[2 * i] = first;
        a_lanes[2 * i + 1] = second;
        even += first * c_lanes[2 * i];
        odd += second * c_lanes[2 * i + 1];
    }
#if LANES == 16
    if (count4 / 4 % 2) {
        const int i = count4 / 4 - 1;
        const lanes left = a_lanes[i] - scale * b_lanes[i];
        a_lanes[i] = left;
        even += left * c_lanes[i];
    }
#endif
    return sum_over_group(sum_of_lanes(even + odd), scratch);
}

OF_BOTH_TYPES void scale_field(vector a, real factor, int count4)
{
    __global lanes *a_lanes = (__global lanes *)a;
    FOR_EACH(i, count4 / (LANES / 4)) a_lanes[i] *= factor;
    SYNC;
}

/* a −= scale b. */
OF_BOTH_TYPES void subtract(vector a, real scale, constant_vector b, int count4)
{
    __global lanes *a_lanes = (__global lanes *)a;
    __global const lanes *b_lanes = (__global const lanes *)b;
    FOR_EACH(i, count4 / (LANES / 4)) a_lanes[i] -= scale * b_lanes[i];
    SYNC;
}
