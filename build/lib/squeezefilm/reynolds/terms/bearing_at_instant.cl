/* Sliding along x: −Λ d(HP)/dX / σ in the rate of the mass y = HP − 1. */
static void rate_bearing(const Grid *g, const Film *film, field y, field work, field out)
{
    const double speed = film->row->bearing / film->sigma;
    matrix4 mass = (matrix4)y, slope_x = (matrix4)ARRAY(film, slope_x), carried = (matrix4)work;
    field4 moved = (field4)film->work_b, r = (field4)out;
    FOR_EACH(i, g->count4) moved[i] = mass[i] - film->excursion * film->amplitude[i];
    SYNC;
    along_x(g, ARRAY(film, derivative_x), film->work_b, work, 0);
    FOR_EACH(i, g->count4) r[i] -= speed * (carried[i] + film->excursion * slope_x[i]);
    SYNC;
}

/* The same of a small change w of the mass, for −c times the rate. */
static void rate_response_bearing(const Grid *g, const Film *film, field w, field work, field out)
{
    const double share = film->stage / film->sigma * film->row->bearing;
    field4 r = (field4)out;
    along_x(g, ARRAY(film, derivative_x), w, work, 0);
    FOR_EACH(i, g->count4) r[i] += share * ((matrix4)work)[i];
    SYNC;
}
