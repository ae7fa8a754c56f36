/* Distances to the goal in a grid of cells, by breadth-first search over the grid itself: what one would write in C
   if the only question were how many moves each cell is from the goal. Walls are 1. */

#include <stdint.h>
#include <string.h>

/* distance[cell]: moves to the goal, -1 where no path leads there. queue: room for every cell. */
void breadth_first(const int8_t *grid, int64_t rows, int64_t columns, int64_t goal, int32_t *distance, int32_t *queue)
{
    int64_t head = 0, tail = 0;
    memset(distance, 0xff, (size_t)(rows * columns) * sizeof *distance);
    distance[goal] = 0;
    queue[tail++] = (int32_t)goal;
    while (head < tail) {
        int64_t cell = queue[head++], row = cell / columns, column = cell % columns;
        int32_t further = distance[cell] + 1;
        if (row > 0 && grid[cell - columns] != 1 && distance[cell - columns] < 0) {
            distance[cell - columns] = further;
            queue[tail++] = (int32_t)(cell - columns);
        }
        if (row < rows - 1 && grid[cell + columns] != 1 && distance[cell + columns] < 0) {
            distance[cell + columns] = further;
            queue[tail++] = (int32_t)(cell + columns);
        }
        if (column > 0 && grid[cell - 1] != 1 && distance[cell - 1] < 0) {
            distance[cell - 1] = further;
            queue[tail++] = (int32_t)(cell - 1);
        }
        if (column < columns - 1 && grid[cell + 1] != 1 && distance[cell + 1] < 0) {
            distance[cell + 1] = further;
            queue[tail++] = (int32_t)(cell + 1);
        }
    }
}
