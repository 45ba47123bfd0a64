    if (status == 0) {
        status = ${name}_project(total, p, at);
    }
    if (status == 0) { /* the second Newton step reaches rounding */
        status = ${name}_project(at, p, out);
    }
