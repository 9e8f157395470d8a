"""Plots the height of the lowest point of every sheet of a running game, live or to a picture.

    sheetwork serve assets/scenes/materials_hanging.ron &
    python tip_height.py                      # a window
    python tip_height.py --seconds 4 --out tip_height.png
"""

import argparse

import sheetwork


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--link", default="", help="name of the link")
    arguments.add_argument("--seconds", type=float, default=None, help="end after so long")
    arguments.add_argument("--out", help="write a picture in place of opening a window")
    arguments.add_argument("--reset", action="store_true", help="put the game back to its start first")
    options = arguments.parse_args()

    import matplotlib

    if options.out:
        matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    times, heights = [], {}
    figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
    axes.set(xlabel="simulated time, s", ylabel="lowest point, m")
    lines = {}

    def draw(title):
        for name, values in heights.items():
            if name not in lines:
                (lines[name],) = axes.plot([], [], label=name, linewidth=1.4)
                axes.legend(loc="best")
            lines[name].set_data(times[-len(values) :], values)
        axes.set_title(title)
        axes.relim()
        axes.autoscale_view()

    with sheetwork.attach(options.link, wait=5.0) as game:
        title = game.status()["scene"]
        if options.reset:
            game.reset()
            game.play()
        for frame in game.frames(seconds=options.seconds):
            if times and frame.time < times[-1]:
                times.clear()
                heights.clear()
            times.append(frame.time)
            for sheet in frame.sheets:
                heights.setdefault(sheet.name, []).append(float(sheet.positions[:, 1].min()))
            if not options.out and len(times) % 8 == 0:
                draw(title)
                plt.pause(1e-3)
                if not plt.fignum_exists(figure.number):
                    return
        draw(f"{title}: {len(times)} frames read, {game.missed} passed over")
    if options.out:
        figure.savefig(options.out, dpi=100)
    else:
        plt.show()


if __name__ == "__main__":
    main()
