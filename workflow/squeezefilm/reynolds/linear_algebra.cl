/* Dense products and sums by the work-items of one work-group.
 *
 * A field is stored [x][y][t] with time innermost, so that every operator of the solver is a
 * small matrix times panels of contiguous numbers. All sizes are multiples of four.
 * With WORK_ITEMS == 1 (a processor core per group) loops are plain loops and need no barrier.
 */

#if WORK_ITEMS == 1
#define SYNC
#define FOR_EACH(index, count) for (int index = 0; index < (count); index++)
/* Four instants at a time: `i` counts double4 of the field, `t` those of the period. */
#define FOR_EACH_POINT(g, row, t, i)                 \
    for (int row = 0, i = 0; row < (g)->rows; row++) \
        for (int t = 0; t < (g)->nt4; t++, i++)
#else
#define SYNC barrier(CLK_GLOBAL_MEM_FENCE | CLK_LOCAL_MEM_FENCE)
#define FOR_EACH(index, count) \
    for (int index = get_local_id(0); index < (count); index += WORK_ITEMS)
#define FOR_EACH_POINT(g, row, t, i)                                                   \
    for (int i = get_local_id(0), row = i / (g)->nt4, t = i % (g)->nt4; i < (g)->count4; \
         i += WORK_ITEMS, row = i / (g)->nt4, t = i % (g)->nt4)
#endif

typedef __global double *field;
typedef __global const double *matrix;
typedef __global double4 *field4;
typedef __global const double4 *matrix4;

/* Four rows of c = a b (+ c) over a width of 1 to 4 double4. `a*b + c` is contracted to a
 * fused multiply-add; an explicit fma() is slow on PoCL. */
#define ROW(i, w) c##i##w += a##i * b##w
#define LOAD(i, w) double4 c##i##w = add ? c[i * ldc + w] : (double4)(0.0)
#define STORE(i, w) c[i * ldc + w] = c##i##w
#define EACH_ROW(STEP, w) STEP(0, w); STEP(1, w); STEP(2, w); STEP(3, w)
#define WIDTH_1(STEP) EACH_ROW(STEP, 0)
#define WIDTH_2(STEP) WIDTH_1(STEP); EACH_ROW(STEP, 1)
#define WIDTH_3(STEP) WIDTH_2(STEP); EACH_ROW(STEP, 2)
#define WIDTH_4(STEP) WIDTH_3(STEP); EACH_ROW(STEP, 3)
#define READ_1 const double4 b0 = row[0]
#define READ_2 READ_1; const double4 b1 = row[1]
#define READ_3 READ_2; const double4 b2 = row[2]
#define READ_4 READ_3; const double4 b3 = row[3]

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
BLOCK(3)
BLOCK(4)

/* Four rows and `width` double4 columns of a panel. */
static inline void multiply_block(matrix a, matrix4 b, field4 c, int stride, int inner, int width,
                                  int add)
{
    switch (width) {
    case 4: block_4(a, inner, b, stride, c, stride, inner, add); break;
    case 3: block_3(a, inner, b, stride, c, stride, inner, add); break;
    case 2: block_2(a, inner, b, stride, c, stride, inner, add); break;
    default: block_1(a, inner, b, stride, c, stride, inner, add);
    }
}

/* Columns of the next block when `left` are left: never one alone beside others, which is slow. */
static inline int block_width(int left) { return left == 5 ? 3 : min(left, 4); }

/* c = a b (+ c) for some panels of b and c, (inner, columns) and (rows, columns) double4 behind each
 * other: a is (rows, inner). */
static void multiply(matrix a, int rows, int inner, matrix4 b, field4 c, int columns, int panels,
                     int add)
{
    const int panel_b = inner * columns, panel_c = rows * columns;
#if WORK_ITEMS == 1
    for (int p = 0; p < panels; p++)
        for (int row = 0; row < rows; row += 4)
            for (int column = 0; column < columns;) {
                const int width = block_width(columns - column);
                multiply_block(a + row * inner, b + p * panel_b + column,
                               c + p * panel_c + row * columns + column, columns, inner, width, add);
                column += width;
            }
#else
    const int row_blocks = rows / 4, column_blocks = (columns + 3) / 4;
    FOR_EACH(task, panels * row_blocks * column_blocks)
    {
        const int p = task / (row_blocks * column_blocks);
        const int row = 4 * (task / column_blocks % row_blocks);
        const int column = 4 * (task % column_blocks);
        multiply_block(a + row * inner, b + p * panel_b + column,
                       c + p * panel_c + row * columns + column, columns, inner,
                       min(columns - column, 4), add);
    }
#endif
    SYNC;
}

/* Sum of one number per work-item, known to all of them; the order of the sum is fixed. Global memory
 * is in step afterwards too: the next loop may share a field among the items in another way. */
static double sum_over_group(double part, __local double *scratch)
{
#if WORK_ITEMS == 1
    return part;
#else
    scratch[get_local_id(0)] = part;
    SYNC;
    for (int span = WORK_ITEMS / 2; span > 0; span /= 2) {
        if (get_local_id(0) < span)
            scratch[get_local_id(0)] += scratch[get_local_id(0) + span];
        SYNC;
    }
    const double sum = scratch[0];
    SYNC;
    return sum;
#endif
}

/* The larger number, or what is none if either is: it must not get lost. */
static double greater(double a, double b) { return a > b || a != a ? a : b; }

static double max_over_group(double part, __local double *scratch)
{
#if WORK_ITEMS == 1
    return part;
#else
    scratch[get_local_id(0)] = part;
    SYNC;
    for (int span = WORK_ITEMS / 2; span > 0; span /= 2) {
        if (get_local_id(0) < span)
            scratch[get_local_id(0)] =
                greater(scratch[get_local_id(0)], scratch[get_local_id(0) + span]);
        SYNC;
    }
    const double most = scratch[0];
    SYNC;
    return most;
#endif
}

static double sum_of(double4 v) { return (v.x + v.y) + (v.z + v.w); }

static double max_of(double4 v) { return greater(greater(v.x, v.y), greater(v.z, v.w)); }

static double4 larger(double4 a, double4 b) { return ((a > b) | (a != a)) ? a : b; }

static double dot_product(matrix4 a, matrix4 b, int count4, __local double *scratch)
{
    double4 even = (double4)(0.0), odd = (double4)(0.0);
    FOR_EACH(i, count4 / 2)
    {
        even += a[2 * i] * b[2 * i];
        odd += a[2 * i + 1] * b[2 * i + 1];
    }
    return sum_over_group(sum_of(even + odd), scratch);
}

/* Root of the sum of squares over `weight`. */
static double norm(field a, int count4, double weight, __local double *scratch)
{
    return sqrt(dot_product((matrix4)a, (matrix4)a, count4, scratch) / weight);
}

/* a −= scale b, and the dot product of the new a with c: one pass over a instead of two. */
static double subtract_and_project(field a, double scale, matrix b, matrix c, int count4,
                                   __local double *scratch)
{
    field4 a4 = (field4)a;
    matrix4 b4 = (matrix4)b, c4 = (matrix4)c;
    double4 even = (double4)(0.0), odd = (double4)(0.0);
    FOR_EACH(i, count4 / 2)
    {
        const double4 first = a4[2 * i] - scale * b4[2 * i];
        const double4 second = a4[2 * i + 1] - scale * b4[2 * i + 1];
        a4[2 * i] = first;
        a4[2 * i + 1] = second;
        even += first * c4[2 * i];
        odd += second * c4[2 * i + 1];
    }
    return sum_over_group(sum_of(even + odd), scratch);
}

static void scale_field(field a, double factor, int count4)
{
    field4 a4 = (field4)a;
    FOR_EACH(i, count4) a4[i] *= factor;
    SYNC;
}

/* a −= scale b. */
static void subtract(field a, double scale, field b, int count4)
{
    field4 a4 = (field4)a;
    matrix4 b4 = (matrix4)b;
    FOR_EACH(i, count4) a4[i] -= scale * b4[i];
    SYNC;
}
