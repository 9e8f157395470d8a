"""The heavy elastica: a clamped strip bent by its own weight, inextensible, of any rotation.

B theta'' = -q (L - s) cos(theta), theta(0) = 0, theta'(L) = 0: B bending stiffness per width, N m; q weight per area, Pa;
s arc length from the clamp, m; theta slope below the horizontal. One number rules it, gamma = q L^3 / B.
"""

from math import cos, pi, sin


def tip_drop(gamma, pieces=2000):
    """Drop of the tip over the length. Shoots from the tip, where the curvature vanishes, for slope 0 at the clamp."""
    low, high = 0.0, pi / 2
    for _ in range(50):
        middle = 0.5 * (low + high)
        if _from_tip(gamma, middle, pieces)[0] > 0.0:
            high = middle
        else:
            low = middle
    return _from_tip(gamma, low, pieces)[1]


def _from_tip(gamma, slope, pieces):
    """Slope at the clamp, and height of the clamp over the tip, of the curve with this slope at its tip (RK4)."""
    h = 1.0 / pieces
    bend = drop = 0.0
    for piece in range(pieces):
        u = piece * h
        k1, b1 = -bend, gamma * u * cos(slope)
        k2, b2 = -(bend + 0.5 * h * b1), gamma * (u + 0.5 * h) * cos(slope + 0.5 * h * k1)
        k3, b3 = -(bend + 0.5 * h * b2), gamma * (u + 0.5 * h) * cos(slope + 0.5 * h * k2)
        k4, b4 = -(bend + h * b3), gamma * (u + h) * cos(slope + h * k3)
        drop += h / 6 * (sin(slope) + 2 * sin(slope + 0.5 * h * k1) + 2 * sin(slope + 0.5 * h * k2) + sin(slope + h * k3))
        slope += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        bend += h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
    return slope, drop
