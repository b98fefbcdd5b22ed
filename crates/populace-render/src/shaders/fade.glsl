// fade.glsl - members that fade in or out.
// Reads    MemberLook of the instance
// Defines  faded_out(): part of the member that is not drawn, 0 to 1

float faded_out() {
    uvec3 bits = look0.xyz >> 30u;
    return float(bits.x | bits.y << 2u | bits.z << 4u) * (1.0 / 63.0);
}
