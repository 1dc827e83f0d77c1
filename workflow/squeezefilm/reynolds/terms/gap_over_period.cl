/* A gap at rest G that is wide at some places and narrow at others: diffusivities go like G² there. A
 * preconditioner of a small one and another of a large one take two parts of each row such that they
 * are right where diffusion is all that counts, and where the rate is: Σ part/D = 1/G², Σ part = 1.
 * Where there is one alone it takes a part that goes about like 1/G, so that both are off by as much.
 * Rows are parted in modes in time, where a rate is a number for each pair (film_over_period.cl). */
#if ROW_PARTS

static void set_parts(const Grid *g, const Film *film)
{
    __global JOIN(real, 4) *squares = (__global JOIN(real, 4) *)film->over_rest_squared;
    __global JOIN(real, 4) *decays = (__global JOIN(real, 4) *)film->decay;
    __global JOIN(real, 4) *speeds = (__global JOIN(real, 4) *)film->speed;
    FOR_EACH(row, g->rows)
    {
        const double rest = 1.0 + film->row->per_rise * film->amplitude[2 * g->rows + row];
        const real square = 1.0 / (rest * rest);
#ifdef HAS_outline
        const real sigma = film->sigma * ARRAY(film, evened)[row];
#else
        const real sigma = film->sigma;
#endif
        for (int t = 0, i = row * g->nt4; t < g->nt4; t++, i++) {
            const real decay = sigma * (real)g->decays[2 * t], speed = sigma * (real)g->speeds[2 * t];
            const real next_decay = sigma * (real)g->decays[2 * t + 1];
            const real next_speed = sigma * (real)g->speeds[2 * t + 1];
            squares[i] = (JOIN(real, 4))(square);
            decays[i] = (JOIN(real, 4))(decay, decay, next_decay, next_decay);
            speeds[i] = (JOIN(real, 4))(speed, -speed, next_speed, -next_speed);
        }
    }
}

/* Of rows the first preconditioner's part in place, the second's in film->second; of rows − σ A dw/dT,
 * if there is a change w of the mass. */
static void part_rows(const Grid *g, const Film *film, vector rows, constant_vector w)
{
    __global lanes *first = (__global lanes *)rows;
    __global const lanes *change = (__global const lanes *)w;
    __global const lanes *squares = (__global const lanes *)film->over_rest_squared;
    __global const lanes *decay = (__global const lanes *)film->decay;
    __global const lanes *speed = (__global const lanes *)film->speed;
    const real even = film->row->part[0], per_square = film->row->part[1];
    FOR_EACH(i, g->count / LANES)
    {
        lanes whole = first[i];
        if (w)
            whole -= decay[i] * change[i] + speed[i] * pairs_swapped(change[i]);
        const lanes part = (even + per_square * squares[i]) * whole;
        first[i] = part;
#if ROW_PARTS > 1
        ((__global lanes *)film->second)[i] = whole - part;
#endif
    }
    SYNC;
}
#endif
