/* The grid over one period and the products with its matrices. `Row` is what the host says of a scene
 * on a grid: its sizes, its numbers, and where its parts lie in the array `values` (layout.py). */

/* The matrices of the linear system, in the type in which GMRES works; those of the modes in time
 * (time_modes.py) are transposed. */
#ifdef HAS_inertia
/* Those of velocities along an axis and of velocities across it (terms/inertia.py). */
typedef struct {
    constant_vector values, slope, along, nodes, divergence, across, edge, to_end;
} Fluxes;
#endif
typedef struct {
    constant_vector laplace_x, laplace_y, modes_x, modes_y, to_modes_x, to_modes_y;
    constant_vector to_time_modes, time_modes;
#ifdef HAS_outline
    constant_vector mass_rate; /* time_modes.py */
    constant_vector modes_by, to_modes_by; /* terms/outline.py */
#endif
#ifdef HAS_inertia
    constant_vector time_derivative, settling, settling_of_slow;
    Fluxes flux[2];
#endif
} Operators;

/* Preconditioners: one for the rows of the linear system as they are, or those that each take a part of
 * them (terms/gap_over_period.cl). */
#define PRECONDITIONERS (ROW_PARTS > 1 ? ROW_PARTS : 1)

/* Sizes and matrices. */
typedef struct {
    int nx, ny, nt, rows, count, nt4, count4, length, length4;
    int spacing; /* from one of the terms' fields to the next */
    /* Axes that stand for all of the pad, and so have their mirror image in them. */
    int whole_x, whole_y, whole_modes_x;
    int around; /* along y are the modes of each of those along x; else the other way round */
    Operators linear;
    matrix laplace_x, laplace_y, eigenvalues, eigenvalues_y, weights;
    matrix time_derivative, mean_resistance, speeds, decays;
    matrix4 sine, cosine;
} Grid;

/* One scene: its numbers and profile, and the fields of the state that is being improved. What terms
 * have of their own they find through the scene's row: numbers as film->row->NAME, and arrays by
 * ARRAY; of those whose term it may not have it says whether it has. A vector of the linear system
 * is `length` long: all unknown fields. */
typedef struct {
    __global const Row *row;
    matrix values;
    double epsilon, sigma, diffusivity;
    matrix amplitude, slope_x, slope_y, laplacian;
    field4 gap_power[FLOW_TERMS], potential[FLOW_TERMS];
    field4 p;
    field means, means_before;
    field work_a, work_b, work_c;
    /* The linear system at the state: per flow term H^(a/2), q and the response to a mass, and what
     * its preconditioner takes each coefficient and its pair's other one by. */
    vector power[FLOW_TERMS], bend[FLOW_TERMS], response[FLOW_TERMS];
    vector diffusion, own_share[PRECONDITIONERS], other_share[PRECONDITIONERS];
    /* A change of the mass on the nodes in modes in time; 1/G² of a gap that is shaped at rest, σ times
     * the rate by a coefficient and its pair's other one, and the second preconditioner's part. */
    vector in_time, over_rest_squared, decay, speed, second;
    /* The Krylov basis, and what its vectors are on the nodes, where that is kept. */
    vector basis, nodal;
    /* Unknowns that terms have of their own, at the state, in a change of it and in what answers to
     * the change; and room for the terms' fields. */
    field own;
    vector own_in, own_out;
    field own_work;
} Film;

/* Copies of what is pointed to: compilers know that no loop stores into them, and keep their members in
 * registers. */
#define AS_COPIES(whole_grid, whole_film)                                \
    const Grid grid_copy = *(whole_grid), *const g = &grid_copy;         \
    const Film film_copy = *(whole_film), *const film = &film_copy;

#define ARRAY(film, name) ((film)->values + (film)->row->name)
/* One of the two arrays along x and along y. */
#define ON_AXIS(axis, name) ((axis) == 0 ? ARRAY(film, name##_x) : ARRAY(film, name##_y))

/* A matrix as GMRES takes it, at `room`, which is moved on; itself if that is no other type. */
static constant_vector taken(matrix values, int count, vector *room)
{
#ifdef SINGLE
    vector copy = *room;
    /* Up to three numbers behind the last are copied with it, and not used. */
    FOR_EACH(i, (count + 3) / 4) store4(((matrix4)values)[i], i, copy);
    *room += (count + 15) / 16 * 16; /* vectors behind it begin where registers do */
    return copy;
#else
    return values;
#endif
}

#define TAKE_FLUXES(axis, name, size)                                                             \
    g.linear.flux[axis] = (Fluxes){taken(values + row->flux_values_##name, size, room),           \
                                   taken(values + row->flux_slope_##name, size, room),            \
                                   taken(values + row->flux_along_##name, size, room),            \
                                   taken(values + row->flux_nodes_##name, size, room),            \
                                   taken(values + row->flux_divergence_##name, size, room),       \
                                   taken(values + row->flux_across_##name, size, room),           \
                                   taken(values + row->flux_edge_##name, 2 * g.n##name, room),    \
                                   taken(values + row->flux_to_end_##name, 4, room)};

/* `room` is for the matrices of the linear system, if they are of another type. */
static Grid make_grid(__global const Row *row, matrix values, vector *room)
{
    Grid g;
    g.nx = row->nx; g.ny = row->ny; g.nt = row->nt;
    g.rows = g.nx * g.ny; g.count = g.rows * g.nt;
    g.length = row->unknown_fields * g.count; g.length4 = g.length / 4;
    g.nt4 = g.nt / 4; g.count4 = g.count / 4; g.spacing = g.count + FIELD_PADDING;
    g.whole_x = row->whole_x; g.whole_y = row->whole_y; g.whole_modes_x = row->whole_modes_x;
    g.laplace_x = values + row->laplace_x;
    g.laplace_y = values + row->laplace_y;
    const int on_x = g.nx * g.nx >> g.whole_x, on_y = g.ny * g.ny >> g.whole_y;
    const int modes_x = g.nx * g.nx >> g.whole_modes_x;
    g.linear.laplace_x = taken(g.laplace_x, on_x, room);
    g.linear.modes_x = taken(values + row->modes_x, modes_x, room);
    g.linear.to_modes_x = taken(values + row->to_modes_x, modes_x, room);
    g.linear.laplace_y = taken(g.laplace_y, on_y, room);
    g.linear.modes_y = taken(values + row->modes_y, on_y, room);
    g.linear.to_modes_y = taken(values + row->to_modes_y, on_y, room);
    g.linear.to_time_modes = taken(values + row->to_time_modes, g.nt * g.nt, room);
    g.linear.time_modes = taken(values + row->time_modes, g.nt * g.nt, room);
    g.mean_resistance = values + row->mean_resistance;
    g.time_derivative = values + row->time_derivative;
#ifdef HAS_outline
    g.linear.mass_rate = taken(values + row->mass_rate, g.nt * g.nt, room);
    g.around = row->around;
    const int by = g.rows * (g.around ? g.ny : g.nx);
    g.linear.modes_by = taken(values + row->modes_by, by, room);
    g.linear.to_modes_by = taken(values + row->to_modes_by, by, room);
#endif
#ifdef HAS_inertia
    g.linear.time_derivative = taken(g.time_derivative, g.nt * g.nt, room);
    g.linear.settling = taken(values + row->settling, g.nt * g.nt, room);
    g.linear.settling_of_slow = taken(values + row->settling_of_slow, g.nt * g.nt, room);
    TAKE_FLUXES(0, x, on_x)
    TAKE_FLUXES(1, y, on_y)
#endif
    g.eigenvalues = values + row->eigenvalues;
    g.eigenvalues_y = values + row->eigenvalues_y;
    g.weights = values + row->weights;
    g.speeds = values + row->speeds;
    g.decays = values + row->decays;
    g.sine = (matrix4)(values + row->sine);
    g.cosine = (matrix4)(values + row->cosine);
    return g;
}

/* A film without angle has one node around, along which gas does not flow (AXES is 1). */
#define IS_NODE(axis) (AXES == 1 && (axis) == 1)

/* Products along the axes; in time out[row][:] = in[row][:] times `transposed` (nt, nt). Along x or y they
 * are by matrices that commute with mirroring, by their parts where the axis has its image in it. No
 * barrier stands in a branch: PoCL copies all that comes behind one. */
#define ALONG_AXES(type)                                                                          \
    OF_BOTH_TYPES void along_t(const Grid *g, __global const type *transposed,                    \
                               __global const type *in, __global type *out, int add)              \
    {                                                                                             \
        multiply(in, g->rows, g->nt, transposed, out, g->nt, 1, add);                             \
    }                                                                                             \
    OF_BOTH_TYPES void along_axis(const Grid *g, int axis, int whole, __global const type *a,     \
                                  int kind, __global const type *in, __global type *out, int add) \
    {                                                                                             \
        const int n = axis == 0 ? g->nx : g->ny;                                                  \
        const int columns = axis == 0 ? g->ny * g->nt : g->nt, panels = axis == 0 ? 1 : g->nx;    \
        if (IS_NODE(axis))                                                                        \
            FOR_EACH(i, g->count) out[i] = a[0] * in[i] + (add ? out[i] : 0);                     \
        else if (whole)                                                                           \
            mirrored_product(a, n / 2, in, out, columns, panels, kind, add);                      \
        else                                                                                      \
            product(a, n, n, in, out, columns, panels, add);                                      \
        SYNC;                                                                                     \
    }                                                                                             \
    /* As the state has it: what terms take. */                                                   \
    OF_BOTH_TYPES void along_axis(const Grid *g, int axis, __global const type *a, int kind,      \
                                  __global const type *in, __global type *out, int add)           \
    {                                                                                             \
        along_axis(g, axis, axis == 0 ? g->whole_x : g->whole_y, a, kind, in, out, add);          \
    }                                                                                             \
    /* out = Δ in. */                                                                             \
    OF_BOTH_TYPES void laplacian(const Grid *g, __global const type *in_x,                        \
                                 __global const type *in_y, __global const type *in,              \
                                 __global type *out)                                              \
    {                                                                                             \
        along_axis(g, 0, g->whole_x, in_x, NODES_TO_NODES, in, out, 0);                           \
        if (!IS_NODE(1))                                                                          \
            along_axis(g, 1, g->whole_y, in_y, NODES_TO_NODES, in, out, 1);                       \
    }
ALONG_AXES(double)
#ifdef SINGLE
ALONG_AXES(float)
#endif

/* modal = to_time_modes values. */
static void to_modes_in_time(const Grid *g, vector values, vector modal)
{
    along_t(g, g->linear.to_time_modes, values, modal, 0);
}

#ifdef HAS_outline
/* Along one axis, for each place of the other one, by a matrix of its own. */
static void by_each(const Grid *g, constant_vector matrices, constant_vector in, vector out)
{
    const int n = g->around ? g->ny : g->nx, others = g->around ? g->nx : g->ny;
    const int stride = g->around ? g->nt : g->ny * g->nt, apart = g->around ? g->ny * g->nt : g->nt;
    const int row_blocks = (n + 3) / 4, column_blocks = (g->nt + LANES - 1) / LANES;
    FOR_EACH(task, others * row_blocks * column_blocks)
    {
        const int other = task / (row_blocks * column_blocks);
        const int row = 4 * (task / column_blocks % row_blocks);
        const int column = LANES * (task % column_blocks), last = g->nt - column;
        constant_vector of_a = matrices + (other * n + row) * n, from_b = in + other * apart + column;
        vector to_c = out + other * apart + row * stride + column;
        if (n - row >= 4)
            block_4_1(of_a, n, from_b, to_c, stride, last, 0);
        else
            block_2_1(of_a, n, from_b, to_c, stride, last, 0);
    }
    SYNC;
}

/* Along the other axis, by the matrix of x or of y. */
static void by_one(const Grid *g, constant_vector of_x, constant_vector of_y, int kind,
                   constant_vector in, vector out)
{
    along_axis(g, !g->around, g->around && g->whole_modes_x, g->around ? of_x : of_y, kind, in, out, 0);
}

static void to_modes_in_space(const Grid *g, vector values, vector modal)
{
    by_one(g, g->linear.to_modes_x, g->linear.to_modes_y, NODES_TO_MODES, modal, values);
    by_each(g, g->linear.to_modes_by, values, modal);
}

static void from_modal(const Grid *g, constant_vector modal, vector in_time, vector values)
{
    by_each(g, g->linear.modes_by, modal, values);
    by_one(g, g->linear.modes_x, g->linear.modes_y, MODES_TO_NODES, values, in_time);
    along_t(g, g->linear.time_modes, in_time, values, 0);
}
#else
/* modal = (to_modes_x ⊗ to_modes_y) modal; `values` is overwritten. */
static void to_modes_in_space(const Grid *g, vector values, vector modal)
{
    along_axis(g, 0, g->whole_modes_x, g->linear.to_modes_x, NODES_TO_MODES, modal, values, 0);
    along_axis(g, 1, g->whole_y, g->linear.to_modes_y, NODES_TO_MODES, values, modal, 0);
}

/* values = (modes_x ⊗ modes_y ⊗ time_modes) modal, by way of `in_time`, which is in modes in time. */
static void from_modal(const Grid *g, constant_vector modal, vector in_time, vector values)
{
    along_axis(g, 0, g->whole_modes_x, g->linear.modes_x, MODES_TO_NODES, modal, values, 0);
    along_axis(g, 1, g->whole_y, g->linear.modes_y, MODES_TO_NODES, values, in_time, 0);
    along_t(g, g->linear.time_modes, in_time, values, 0);
}

#endif

/* What the gap is more than 1 at some place and four instants, by its parts there: s or, behind each
 * other, s₁, s₂ and what it is at rest, in metres (packing.py). By their slopes, the gap's slope. */
static double4 beyond_even(const Grid *g, const Film *film, matrix parts, int row, int t)
{
#ifdef HAS_any_gap
    return film->row->per_rise * parts[2 * g->rows + row] +
           film->epsilon * (parts[row] * g->sine[t] + parts[g->rows + row] * g->cosine[t]);
#else
    return film->epsilon * parts[row] * g->sine[t];
#endif
}

/* How fast the gap grows there. */
static double4 rate_by(const Grid *g, const Film *film, matrix parts, int row, int t)
{
#ifdef HAS_any_gap
    return film->epsilon * (parts[row] * g->cosine[t] - parts[g->rows + row] * g->sine[t]);
#else
    return film->epsilon * parts[row] * g->cosine[t];
#endif
}

static double4 gap_at(const Grid *g, const Film *film, int row, int t)
{
    return 1.0 + beyond_even(g, film, film->amplitude, row, t);
}

/* Coefficient of first-order slip, 6 Kn. */
static double slip_of(const Film *film)
{
    return FLOW_TERMS == 2 ? film->row->flow[FLOW_TERMS - 1] : 0.0;
}

/* −V over the pressure's slope, with V as of inertia.py. */
static double4 mobility(const Film *film, double4 gap, double4 density)
{
    return gap * (gap + slip_of(film) / density) / film->sigma;
}

/* Re ρ H²/10 with what slip makes of it. */
static double4 lag_of(const Film *film, double4 gap, double4 density)
{
    return film->row->lag * gap * (density * gap + slip_of(film) / 1.5);
}

/* 1/G² at four instants, for a gap that is shaped at rest. */
static double4 over_rest_squared(const Film *film, int i)
{
#if ROW_PARTS
    return in_double(((__global const JOIN(real, 4) *)film->over_rest_squared)[i]);
#else
    return (double4)(1.0);
#endif
}

/* The diffusivity by which one of the preconditioners works. */
static double diffusivity_of(const Film *film, int which)
{
#if ROW_PARTS
    return film->row->diffusivities[which] * film->diffusivity;
#else
    return film->diffusivity;
#endif
}

/* A field of the coarser grid of another row on g, by the matrices from axis to axis. */
static void carry_field(const Grid *g, const Film *film, __global const Row *coarser, matrix in_t,
                        matrix in_x, matrix in_y, field coarse, field fine)
{
    const int nx = coarser->nx, ny = coarser->ny, nt = coarser->nt;
    multiply((matrix)coarse, nx * ny, nt, in_t, film->work_a, g->nt, 1, 0);
    multiply(in_x, g->nx, nx, (matrix)film->work_a, IS_NODE(1) ? fine : film->work_b, ny * g->nt, 1, 0);
    if (!IS_NODE(1))
        multiply(in_y, g->ny, ny, (matrix)film->work_b, fine, g->nt, g->nx, 0);
}
