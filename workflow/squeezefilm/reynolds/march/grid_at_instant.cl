/* The grid at one instant and the products with its matrices. `Row` is what the host says of a scene,
 * as in grid_over_period.cl; matrices that act along y are stored transposed, to be multiplied from
 * the right. A field is stored [x][y], so that both derivatives are products with contiguous rows. */

typedef struct {
    int nx, ny, ny4, count, count4, length, length4;
    matrix laplace_x, laplace_y, area, modes_x, to_modes_x, modes_y, to_modes_y, eigenvalues;
} Grid;

typedef struct {
    __global const Row *row;
    matrix values;
    double epsilon, sigma, excursion, diffusivity, stage;
    matrix4 amplitude, slope_x, slope_y, laplacian;
    field4 overpressure, inverse_gap, power, potential, response;
    field work_a, work_b;
} Film;

#define ARRAY(film, name) ((film)->values + (film)->row->name)

static Grid make_grid(__global const Row *row, matrix values)
{
    Grid g;
    g.nx = row->nx; g.ny = row->ny; g.ny4 = g.ny / 4;
    g.count = g.length = g.nx * g.ny; g.count4 = g.length4 = g.count / 4;
    g.laplace_x = values + row->laplace_x;
    g.laplace_y = values + row->laplace_y;
    g.area = values + row->area;
    g.modes_x = values + row->modes_x;
    g.to_modes_x = values + row->to_modes_x;
    g.modes_y = values + row->modes_y;
    g.to_modes_y = values + row->to_modes_y;
    g.eigenvalues = values + row->eigenvalues;
    return g;
}

static void along_x(const Grid *g, matrix a, field in, field out, int add)
{
    multiply(a, g->nx, g->nx, in, out, g->ny, 1, add);
}

static void along_y(const Grid *g, matrix transposed, field in, field out, int add)
{
    multiply(in, g->nx, g->ny, transposed, out, g->ny, 1, add);
}
