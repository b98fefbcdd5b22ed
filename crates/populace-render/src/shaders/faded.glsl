// faded.glsl - fragments of members that fade in or out, in the variants FADED.
// Reads    outputs of member.vert or marks.vert
// Defines  is_faded_out(): whether the member leaves out this sample or pixel

flat in float faded;

// Returns a threshold from 0 to 1 whose values are spread evenly over neighbouring places
// (J. Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare", 2014).
float threshold(vec2 place) {
    return fract(52.9829189 * fract(dot(place, vec2(0.06711056, 0.00583715))));
}

bool is_faded_out() { return threshold(gl_FragCoord.xy) < faded; }
