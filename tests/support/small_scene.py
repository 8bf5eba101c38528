"""A scene without a camera: it remembers where it was to look, what was drawn, and which moments were asked for."""

from webui.scene.moving import RobotView
from webui.scene.scene import View


class SmallScene:
    def __init__(self, page, strokes=()):
        self.robot, self.strokes = RobotView(page.client.scene), list(strokes)
        self.view = View()
        self.is_live, self.stamps = False, []
        self.looked, self.layers, self.sought, self.followers = [], {}, [], []
        page.follow(lambda now: self.robot.show_cell(now.cell and now.cell.cell), lambda now: now.cell)

    def change_view(self, view):
        self.view = view

    def on_moment(self, follow):
        self.followers.append(follow)

    def seek(self, time_s):
        self.sought.append(time_s)
        for follow in self.followers:
            follow(time_s)

    def show_live(self, joints, tool, seconds):
        self.robot.stand(joints, tool)
        self.stamps.append(seconds)

    def draw_over(self, name, glb):
        self.layers[name] = glb

    def look_at(self, place):
        self.looked.append(place.name)

    def look_at_cell(self):
        self.looked.append("cell")

    def look_at_board(self):
        self.looked.append("board")

    def look_at_place(self, place, around_mm=15.0):
        self.looked.append((place, around_mm))
