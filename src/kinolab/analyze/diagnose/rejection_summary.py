"""Which motions were refused, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

MAX_NAMED = 4
MIN_FRACTION = 0.01  # share of all refused motions below which a culprit is not named


def rejection_sentences(rejections: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    """Name what refused most motions, by cause and culprit.

    Args:
        rejections: Share of all refused motions, by cause and by who is to blame.
    """
    shares = [
        (fraction, cause, culprit)
        for cause, culprits in rejections.items()
        for culprit, fraction in culprits.items()
        if fraction >= MIN_FRACTION
    ]
    named = [
        f"{cause}, {culprit} ({fraction:.0%})"
        for fraction, cause, culprit in sorted(shares, key=lambda entry: -entry[0])[:MAX_NAMED]
    ]
    if named:
        yield f"Motions were refused for: {'; '.join(named)}."
