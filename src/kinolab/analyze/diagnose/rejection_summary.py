"""Which motions were refused, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

SHOWN = 4
LEAST = 0.01  # share of all refused motions below which a culprit is not named


def refusal_sentences(rejections: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    """Name what refused most motions, by cause and culprit.

    Args:
        rejections: Share of all refused motions, by cause and by who is to blame.
    """
    shares = [
        (share, cause, culprit)
        for cause, culprits in rejections.items()
        for culprit, share in culprits.items()
        if share >= LEAST
    ]
    named = [
        f"{cause}, {culprit} ({share:.0%})"
        for share, cause, culprit in sorted(shares, key=lambda entry: -entry[0])[:SHOWN]
    ]
    if named:
        yield f"Motions were refused for: {'; '.join(named)}."
