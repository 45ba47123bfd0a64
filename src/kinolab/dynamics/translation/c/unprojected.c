    for (size_t i = 0; i < N; ++i) {
        out[i] = total[i];
    }
    if ((status == 0) && !all_finite(out, N)) {
        status = 2;
    }
