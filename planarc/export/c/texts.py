"""What the files of a model hold beside its translated functions."""

#: The mark of own files, in their first lines.
WRITTEN = "Written by planarc"

COUNT = """static int64_t count_bits(int64_t number)
{
    int64_t count = 0;
    for (uint64_t rest = (uint64_t)number; rest != 0; rest &= rest - 1)
        count++;
    return count;
}"""

HEADER = """/* {title}
   Written by planarc: compile it with {how}. */

#ifndef MODEL_H
#define MODEL_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/* What an instance is made of: numbers, whole numbers and pointers, 8 bytes each. */
typedef union word {{
    double d;
    int64_t i;
    union word *p;
}} word;

{api}

/* The variables. */
enum {{
{slots}
}};

#endif
"""

API = """\
/* An instance as it was exported, in memory that it is given once; NULL where there is none. */
word *model_new(void);
/* Set a parameter or a start value before the begin, an input at any time. 0: done;
   1: not now; 2: there is no such variable; 3: the value is not finite. */
int32_t model_set(word *m, int32_t variable, double value);
/* Find start values that fit together; not 0 where there are none. */
int32_t model_begin(word *m);
/* Go on to a time. 0: done; above 0: the number of the message that the run ended with;
   -1: no step leads on. */
int32_t model_go(word *m, double t);
/* The text of a message, which stands until the next one is asked for. */
word *model_message(word *m, int32_t number);

/* The value of a variable, `model_value(m, V_time)`; whether the model itself ended the run. */
#define model_value(m, variable) ((m)->p[variable].d)
#define model_is_over(m) ((m)[{over}].i == 1)"""

LIBRARY = """/* Sizes are those of processors of 64 bits. */
typedef char has_64_bits[sizeof(void *) == 8 && sizeof(size_t) == 8 ? 1 : -1];

/* A library shows the functions of the standard. */
#ifdef _WIN32
#define EXPORTED __declspec(dllexport)
#elif defined __GNUC__
#define EXPORTED __attribute__((visibility("default")))
#ifndef __MINGW32__
#pragma GCC visibility push(hidden)
#endif
#else
#define EXPORTED
#endif

/* Models that are linked into one program need names of their own. */
#ifdef {prefix}
#define PASTED(a, b) a##b
#define PREFIXED(a, b) PASTED(a, b)
{renamed}
#endif

{declared}"""

INNER = """/* What the files of the model share: places in an instance, functions, tables.
   Written by planarc. */

#ifndef RUNTIME_H
#define RUNTIME_H

#include "model.h"

/* The words of an instance. */
enum {{
{own}
}};

/* Numbers that the blocks of equations keep, in m[FRAME_NUMBERS].p. */
enum {{
{numbers}
}};

/* Numbers of the model, in px_plan. */
enum {{
{table}
}};

{declared}

#endif
"""

MAIN = """/* {title}: runs the experiment and writes its outputs as CSV.
   Written by planarc. */

#include "model.h"

#include <stdio.h>

#define START {start}
#define STOP {stop}
#define INTERVAL {interval}
#define ROWS {rows}

static const struct {{
    const char *name;
    int32_t variable;
    double sign;
}} outputs[] = {{
{outputs}
}};
#define OUTPUTS (sizeof outputs / sizeof outputs[0])

static void write_row(const word *m)
{{
    printf("%.17g", model_value(m, V_time));
    for (size_t i = 0; i < OUTPUTS; i++)
        printf(",%.17g", outputs[i].sign * model_value(m, outputs[i].variable));
    printf("\\n");
}}

int main(void)
{{
    word *m = model_new();
    if (m == NULL || model_begin(m) != 0) {{
        fprintf(stderr, "the model does not start\\n");
        return 1;
    }}
    printf("time");
    for (size_t i = 0; i < OUTPUTS; i++)
        printf(",%s", outputs[i].name);
    printf("\\n");
    int32_t flag = 0;
    for (int row = 0; row < ROWS && flag == 0; row++) {{
        flag = model_go(m, row < ROWS - 1 ? START + row * INTERVAL : STOP);
        if (flag >= 0)
            write_row(m);
    }}
    if (flag > 0)
        fprintf(stderr, "%s\\n", (const char *)model_message(m, flag));
    if (flag < 0)
        fprintf(stderr, "no step leads on from %g s\\n", model_value(m, V_time));
    bool ended = flag == 0 || (flag > 0 && model_is_over(m));
    free(m);
    return ended ? 0 : 1;
}}
"""
