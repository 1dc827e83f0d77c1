/* A given pressure on the edge (edge_pressure.py): what it adds to the flow on the nodes, and, for the
 * terms of velocities, to the pressure and its slope along an axis on the points of these. */

/* Where the edge has ambient pressure, nothing; no branch, for a barrier must not stand in one. */
static void add_edge_part(const Grid *g, const Film *film, matrix part, field values)
{
    FOR_EACH(i, film->row->has_edge_pressure ? g->count4 : 0)
        ((field4)values)[i] += ((matrix4)part)[i];
    SYNC;
}

static void residual_edge_pressure(const Grid *g, const Film *film, field mass, field work, field out)
{
    add_edge_part(g, film, ARRAY(film, edge_flow), out);
}

static void add_edge_pressure(const Grid *g, const Film *film, int axis, field pressure, field slope)
{
    add_edge_part(g, film, ON_AXIS(axis, edge_values), pressure);
    add_edge_part(g, film, ON_AXIS(axis, edge_slope), slope);
}
