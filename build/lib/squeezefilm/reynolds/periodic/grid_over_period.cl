/* The grid over one period and the products with its matrices. `Row` is what the host says of a scene
 * on a grid: its sizes, its numbers, and where its parts lie in the array `values` (layout.py). */

typedef __global double2 *pair;
typedef __global const double2 *pairs;

/* Sizes and matrices; those of the modes in time (time_modes.py) are transposed. */
typedef struct {
    int nx, ny, nt, rows, count, nt4, row4, count4, length, length4;
    matrix laplace_x, laplace_y, modes_x, modes_y, to_modes_x, to_modes_y;
    matrix eigenvalues, eigenvalues_y, weights;
    pairs speeds, decays;
    matrix to_time_modes, time_modes, time_derivative, mean_gap;
    matrix4 sine, cosine;
} Grid;

/* One scene: its numbers and profile, and the fields of the state that is being improved. What terms
 * have of their own they find through the scene's row: numbers as film->row->NAME, and arrays by
 * ARRAY. A vector of the linear system is `length` long: UNKNOWN_FIELDS fields. */
typedef struct {
    __global const Row *row;
    matrix values;
    double epsilon, sigma, diffusivity;
    matrix amplitude, gradient_squared, laplacian;
    field4 gap_power[FLOW_TERMS], potential[FLOW_TERMS], response[FLOW_TERMS];
    field4 p;
    field work_a, work_b, work_c;
    /* Unknowns that terms have of their own, at the state, in a change of it and in what answers to
     * the change; and room for the terms' fields. */
    field own, own_in, own_out, own_work;
} Film;

#define ARRAY(film, name) ((film)->values + (film)->row->name)

static Grid make_grid(__global const Row *row, matrix values)
{
    Grid g;
    g.nx = row->nx; g.ny = row->ny; g.nt = row->nt;
    g.rows = g.nx * g.ny; g.count = g.rows * g.nt;
    g.length = UNKNOWN_FIELDS * g.count; g.length4 = g.length / 4;
    g.nt4 = g.nt / 4; g.row4 = g.ny * g.nt / 4; g.count4 = g.count / 4;
    g.laplace_x = values + row->laplace_x;
    g.modes_x = values + row->modes_x;
    g.to_modes_x = values + row->to_modes_x;
    g.laplace_y = values + row->laplace_y;
    g.modes_y = values + row->modes_y;
    g.to_modes_y = values + row->to_modes_y;
    g.to_time_modes = values + row->to_time_modes;
    g.time_modes = values + row->time_modes;
    g.mean_gap = values + row->mean_gap;
    g.time_derivative = values + row->time_derivative;
    g.eigenvalues = values + row->eigenvalues;
    g.eigenvalues_y = values + row->eigenvalues_y;
    g.weights = values + row->weights;
    g.speeds = (pairs)(values + row->speeds);
    g.decays = (pairs)(values + row->decays);
    g.sine = (matrix4)(values + row->sine);
    g.cosine = (matrix4)(values + row->cosine);
    return g;
}

static void along_x(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, g->nx, g->nx, (matrix4)in, (field4)out, g->row4, 1, add);
}

static void along_y(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, g->ny, g->ny, (matrix4)in, (field4)out, g->nt4, g->nx, add);
}

/* out[row][:] = in[row][:] times `transposed` (nt, nt). */
static void along_t(const Grid *g, matrix transposed, field in, field out, int add)
{
    multiply(in, g->rows, g->nt, (matrix4)transposed, (field4)out, g->nt4, 1, add);
}

/* modal = (to_modes_x ⊗ to_modes_y ⊗ to_time_modes) values; `values` is overwritten. */
static void to_modal(const Grid *g, field values, field modal)
{
    along_t(g, g->to_time_modes, values, modal, 0);
    along_x(g, g->to_modes_x, modal, values, 0);
    along_y(g, g->to_modes_y, values, modal, 0);
}

/* values = (modes_x ⊗ modes_y ⊗ time_modes) modal, by way of `work`. */
static void from_modal(const Grid *g, field modal, field work, field values)
{
    along_x(g, g->modes_x, modal, values, 0);
    along_y(g, g->modes_y, values, work, 0);
    along_t(g, g->time_modes, work, values, 0);
}

static double4 gap_at(const Grid *g, const Film *film, int row, int t)
{
    return 1.0 + film->epsilon * film->amplitude[row] * g->sine[t];
}

/* A field of the coarser grid of another row on g, by the matrices from axis to axis. */
static void carry_field(const Grid *g, const Film *film, __global const Row *coarser, matrix in_t,
                        matrix in_x, matrix in_y, field coarse, field fine)
{
    const int nx = coarser->nx, ny = coarser->ny, nt = coarser->nt;
    multiply(coarse, nx * ny, nt, (matrix4)in_t, (field4)film->work_a, g->nt4, 1, 0);
    multiply(in_x, g->nx, nx, (matrix4)film->work_a, (field4)film->work_b, ny * g->nt4, 1, 0);
    multiply(in_y, g->ny, ny, (matrix4)film->work_b, (field4)fine, g->nt4, g->nx, 0);
}
