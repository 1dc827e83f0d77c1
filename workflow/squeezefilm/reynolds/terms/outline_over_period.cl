/* The area behind a point of a smooth outline: −σ (J/J̄ − 1) d(Hρ)/dT. */

/* The same for a change, of which the modes in space know a part: J/J̄ averaged along an axis. */
static void response_outline(const Grid *g, const Film *film, vector mass, vector work, vector out)
{
    along_t(g, g->linear.mass_rate, mass, work, 0);
    matrix uneven = ARRAY(film, uneven);
    const double sigma = film->sigma;
    FOR_EACH_POINT(g, row, t, i)
    {
        __global JOIN(real, 4) *to = (__global JOIN(real, 4) *)out;
        to[i] -= (real)(sigma * uneven[row]) * ((__global const JOIN(real, 4) *)work)[i];
    }
    SYNC;
}

/* out −= σ (J/J̄ − 1) d(Hρ)/dT, of which that of the gap at ambient density is known. */
static void residual_outline(const Grid *g, const Film *film, field excess, field work, field out)
{
    along_t(g, g->time_derivative, excess, work, 0);
    matrix stretch = ARRAY(film, stretch);
    field4 out4 = (field4)out;
    matrix4 rate = (matrix4)work;
    FOR_EACH_POINT(g, row, t, i)
    {
        out4[i] -= film->sigma * stretch[row] *
                   (rate[i] + rate_by(g, film, film->amplitude, row, t));
    }
    SYNC;
}
