/* Dense products and sums by the work-items of one work-group.
 *
 * A field is stored [x][y][t] with time innermost, so that every operator of the solver is a
 * small matrix times panels of contiguous numbers. All sizes are multiples of four.
 * With WORK_ITEMS == 1 (a processor core per group) loops are plain loops and need no barrier.
 */

#if WORK_ITEMS == 1
#define SYNC
#define FOR_EACH(index, count) for (int index = 0; index < (count); index++)
#define FOR_EACH_POINT(g, row, t, i)                 \
    for (int row = 0, i = 0; row < (g)->rows; row++) \
        for (int t = 0; t < (g)->nt; t++, i++)
#else
#define SYNC barrier(CLK_GLOBAL_MEM_FENCE | CLK_LOCAL_MEM_FENCE)
#define FOR_EACH(index, count) \
    for (int index = get_local_id(0); index < (count); index += WORK_ITEMS)
#define FOR_EACH_POINT(g, row, t, i)                                             \
    for (int i = get_local_id(0), row = i / (g)->nt, t = i % (g)->nt; i < (g)->count; \
         i += WORK_ITEMS, row = i / (g)->nt, t = i % (g)->nt)
#endif

typedef __global double *field;
typedef __global const double *matrix;
typedef __global double4 *field4;
typedef __global const double4 *matrix4;

/* Four rows of c = a b (+ c) over a width of 1, 2 or 4 double4. `a*b + c` is contracted to a
 * fused multiply-add; an explicit fma() is slow on PoCL. */
#define ROW(i, w) c##i##w += a##i * b##w
#define LOAD(i, w) double4 c##i##w = add ? c[i * ldc + w] : (double4)(0.0)
#define STORE(i, w) c[i * ldc + w] = c##i##w
#define EACH_ROW(STEP, w) STEP(0, w); STEP(1, w); STEP(2, w); STEP(3, w)
#define WIDTH_1(STEP) EACH_ROW(STEP, 0)
#define WIDTH_2(STEP) WIDTH_1(STEP); EACH_ROW(STEP, 1)
#define WIDTH_4(STEP) WIDTH_2(STEP); EACH_ROW(STEP, 2); EACH_ROW(STEP, 3)
#define READ_1 const double4 b0 = row[0]
#define READ_2 READ_1; const double4 b1 = row[1]
#define READ_4 READ_2; const double4 b2 = row[2], b3 = row[3]

#define BLOCK(WIDTH)                                                                        \
    static inline void block_##WIDTH(matrix a, int lda, matrix4 b, int ldb, field4 c,       \
                                     int ldc, int inner, int add)                           \
    {                                                                                       \
        WIDTH_##WIDTH(LOAD);                                                                \
        for (int k = 0; k < inner; k++) {                                                   \
            matrix4 row = b + k * ldb;                                                      \
            READ_##WIDTH;                                                                   \
            const double a0 = a[k], a1 = a[lda + k], a2 = a[2 * lda + k], a3 = a[3 * lda + k]; \
            WIDTH_##WIDTH(ROW);                                                             \
        }                                                                                   \
        WIDTH_##WIDTH(STORE);                                                               \
    }

BLOCK(1)
BLOCK(2)
BLOCK(4)

/* c = a b (+ c) for `panels` panels: a is (rows, inner); b and c have `columns` double4 in a row,
 * `ldb` apart in b and c, and their panels start `panel` double4 apart (a's panels `panel_a`). */
static void multiply(matrix a, int panel_a, int rows, int inner, matrix4 b, int panel_b, field4 c,
                     int panel_c, int columns, int panels, int add)
{
    const int row_blocks = rows / 4, column_blocks = (columns + 3) / 4;
    FOR_EACH(task, panels * row_blocks * column_blocks)
    {
        const int panel = task / (row_blocks * column_blocks);
        const int row = 4 * (task / column_blocks % row_blocks);
        const int column = 4 * (task % column_blocks);
        matrix a_block = a + panel * panel_a + row * inner;
        matrix4 b_block = b + panel * panel_b + column;
        field4 c_block = c + panel * panel_c + row * columns + column;
        const int left = columns - column;
        if (left >= 4) {
            block_4(a_block, inner, b_block, columns, c_block, columns, inner, add);
        } else {
            if (left & 2)
                block_2(a_block, inner, b_block, columns, c_block, columns, inner, add);
            if (left & 1)
                block_1(a_block, inner, b_block + (left & 2), columns, c_block + (left & 2),
                        columns, inner, add);
        }
    }
    SYNC;
}

/* Sum of one number per work-item, known to all of them; the order of the sum is fixed. */
static double sum_over_group(double part, __local double *scratch)
{
#if WORK_ITEMS == 1
    return part;
#else
    scratch[get_local_id(0)] = part;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int span = WORK_ITEMS / 2; span > 0; span /= 2) {
        if (get_local_id(0) < span)
            scratch[get_local_id(0)] += scratch[get_local_id(0) + span];
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    const double sum = scratch[0];
    barrier(CLK_LOCAL_MEM_FENCE);
    return sum;
#endif
}

static double max_over_group(double part, __local double *scratch)
{
#if WORK_ITEMS == 1
    return part;
#else
    scratch[get_local_id(0)] = part;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int span = WORK_ITEMS / 2; span > 0; span /= 2) {
        if (get_local_id(0) < span)
            scratch[get_local_id(0)] =
                fmax(scratch[get_local_id(0)], scratch[get_local_id(0) + span]);
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    const double most = scratch[0];
    barrier(CLK_LOCAL_MEM_FENCE);
    return most;
#endif
}

static double dot_product(matrix4 a, matrix4 b, int count, __local double *scratch)
{
    double4 sum = (double4)(0.0);
    FOR_EACH(i, count) sum += a[i] * b[i];
    return sum_over_group(sum.x + sum.y + sum.z + sum.w, scratch);
}
